"""A sample of damaged inputs, from files, settings and gallery cases; `validation/mutated-inputs` has ten thousand."""

import warnings

import pytest
from mutated_inputs import KINDS, trial

N = 200
SOME = 40
"""Trials of one test."""


@pytest.mark.parametrize("first", range(0, N, SOME))
def test_no_damaged_input_ends_in_a_traceback_takes_long_or_leaves_a_file(first, tmp_path):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # readers of meshes say what they miss
        outcomes = [trial(20_000 + number, tmp_path) for number in range(first, first + SOME)]
    wrong = [f"{one.kind} of {one.origin}: {one.wrong}\n{one.message}" for one in outcomes if one.wrong]
    assert not wrong, "\n".join(wrong)
    assert {one.kind for one in outcomes} == set(KINDS)
    assert len({one.message for one in outcomes}) > SOME // 2, "trials are damaged in different ways"


def test_what_is_not_damaged_is_accepted(tmp_path):
    from mutated_inputs import cases_with_files, validate

    for name, case, data in cases_with_files():
        (tmp_path / name).write_bytes(data)
        (tmp_path / "case.toml").write_text(case.replace("FILE", name))
        validate(str(tmp_path / "case.toml"))
