"""Two commands on one folder, in any order and at the same time: nothing is lost, and what goes on ends in the same bits."""

import itertools
from contextlib import suppress

import pytest
from commands_of_runs import (
    OFTEN,
    begin,
    begin_another,
    begin_in_part,
    go_on,
    go_on_in_part,
    go_on_with_another_limit,
    results,
    write_plain_report,
)
from free_flight import free_flight
from other_processes import PATIENCE, REFUSED, start_together

from pellucid.errors import UsageError
from pellucid.results.storage.run import Run
from pellucid.running.launch import resume_case, run_case

pytestmark = pytest.mark.usefixtures("fake")

COMMANDS = (begin, begin_another, go_on, go_on_in_part, go_on_with_another_limit, write_plain_report)


def killed(out):
    """A run that was killed after its first checkpoint: no summary, a draft, a row too many."""
    run_case(free_flight(**OFTEN), out, until=0.4, report=False)
    (out / "summary.json").unlink()
    (out / "checkpoint/.writing").write_bytes(b"half")
    with (out / "history.csv").open("a") as file:
        file.write("0.5,17,0.03,1.0")


STATES = (begin, begin_in_part, killed)
PAIRS = [  # each command is the first, and the second, in each state
    (STATES[(i + j) % 3], first, second) for i, first in enumerate(COMMANDS) for j, second in enumerate(COMMANDS)
]


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """What runs that nothing disturbed leave, by their end."""
    return {end: tmp_path_factory.mktemp("whole") / str(end) for end in (0.5, 1.0)}


@pytest.mark.parametrize(("state", "first", "second"), PAIRS)
def test_one_after_the_other(tmp_path, whole, state, first, second):
    for end, folder in whole.items():
        if not folder.exists():
            run_case(free_flight(**{"time.end": end}), folder, report=False)
    out = tmp_path / "run"
    state(out)
    (out / "figures").mkdir(exist_ok=True)
    own = {out / name: name.encode() for name in ("notes.txt", "figures/mine.png", "checkpoint/mine.npz")}
    for path, data in own.items():
        path.write_bytes(data)
    for command in (first, second):
        before = results_or_none(out)
        try:
            command(out)
        except UsageError:  # `until` may be past: then all is as it was
            assert results_or_none(out) == before
    assert {path: path.read_bytes() for path in own} == own
    resume_case(out, report=False)
    assert results(out) == results(whole[Run(out).case.time.end])


def results_or_none(out):
    with suppress(FileNotFoundError):
        return results(out)


@pytest.mark.parametrize("pair", list(itertools.combinations_with_replacement((begin, go_on, write_plain_report), 2)))
def test_at_the_same_time(tmp_path, whole, pair):
    if not whole[1.0].exists():
        run_case(free_flight(), whole[1.0], report=False)
    out = tmp_path / "run"
    begin_in_part(out)
    processes = start_together(pair, out)
    for process in processes:
        process.join(PATIENCE)
    ends = [process.exitcode for process in processes]
    assert set(ends) <= {0, REFUSED}
    assert 0 in ends
    resume_case(out, report=False)
    assert results(out) == results(whole[1.0])
