from types import SimpleNamespace

from pellucid.simulation.ranks import idle

FIELD = SimpleNamespace(grid=SimpleNamespace(rows=[0, 10, 20]))


def test_processes_without_work_are_told_of():
    assert idle(1, []) is None
    assert idle(2, [FIELD]) is None
    assert "no grid: each of 2 processes" in idle(2, [])
    assert "2 rows of slabs, and 1 of 3 processes have none: start 2 at most" in idle(3, [FIELD])
