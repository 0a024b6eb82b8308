from types import SimpleNamespace

import pytest

from pellucid.errors import CaseError
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase
from pellucid.ranks.domain import domain
from pellucid.simulation.ranks import cut_rows, idle

FIELD = SimpleNamespace(grid=SimpleNamespace(rows=[0, 10, 20]))


def test_processes_without_work_are_told_of():
    assert idle(1, []) is None
    assert idle(2, [FIELD]) is None
    assert "no grid, so each of 2 processes" in idle(2, [])
    assert "only 2 rows of slabs, so 1 of 3 processes are idle. Start at most 2." in idle(3, [FIELD])


def test_rows_that_would_meet_across_a_seam_are_refused(monkeypatch):
    monkeypatch.setattr(domain, "group", SimpleNamespace(size=2))
    case = GridCase(lower=(0, 0, 0), upper=(8, 8, 0), cell=1.0, periodic=["x", "y"])
    with pytest.raises(CaseError, match=r"(?s)grid.periodic.*periodic along all axes cannot be shared.*one process"):
        cut_rows([], case, Grid(case))
