"""The files that a case reads beside its own."""

import pytest
from small_cases import RATE_SOLID, box, case

from pellucid.case import Case
from pellucid.errors import UsageError
from pellucid.results.storage.identity import digests
from pellucid.running.launch import _same_inputs


def test_a_run_goes_on_only_with_the_files_that_it_began_with(tmp_path):
    table = tmp_path / "motion.csv"
    table.write_text("0,0\n1,0.1\n")
    signal = {"kind": "table", "path": str(table)}
    data = case(box((1, 1, 1), (3, 3, 3), RATE_SOLID)).to_data()
    moved = Case.model_validate(data | {"motion": [{"name": "m", "body": "block", "displacement": {"x": signal}}]})
    before = digests(moved)
    assert list(before) == [str(table)]
    _same_inputs(moved, before)
    table.write_text("0,0\n1,0.2\n")
    with pytest.raises(UsageError, match=r"motion\.csv has changed since the run started\.\n    Restore the old file"):
        _same_inputs(moved, before)


def test_most_cases_read_nothing():
    assert digests(case(box((1, 1, 1), (3, 3, 3), RATE_SOLID))) == {}
