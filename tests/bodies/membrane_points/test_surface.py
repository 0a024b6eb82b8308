"""Membranes of points that the grid tears are warned of once; those that stretch less are not, nor those that damage tore."""

import warnings

import numpy as np
import pytest
from membranes import body_of, drive, sheet
from small_cases import case

from pellucid.simulation.simulation import Simulation
from pellucid.step.part import WARNING_INTERVAL

CELL = 0.25  # of the grid of `body_of`, with edges of 0.1 m and diagonals of 0.14 m


@pytest.mark.parametrize(("stretch", "is_torn"), [(2.0, False), (3.5, False), (4.0, True)])
def test_edges_beyond_one_and_a_half_cells_are_torn(stretch, is_torn):
    grid, body = body_of(sheet(edges=((0.5, 0, 0), (0, 0.5, 0)), points=(6, 6)))
    drive(grid, body, np.diag([np.log(stretch), 0.0, 0.0]), 0.001, 1000)
    text = body.state_warning()
    assert (text is not None) == is_torn
    if text is not None:
        assert "membrane sheet is torn: its triangle at" in text
        assert "1.6 cells of 0.25 m" in text
        assert 'a finer surface, or kind = "membrane-elements"' in text
        assert "grid.cell" not in text


def test_triangles_of_failed_points_do_not_count():
    damage = {"elastic_limit": 0.1, "stiffness_loss": 10, "rate": 10, "failure_strain": 0.2}
    table = sheet(edges=((0.5, 0, 0), (0, 0.5, 0)), points=(6, 6))
    table["material"] |= {"damage": damage}
    grid, body = body_of(table)
    drive(grid, body, np.diag([np.log(4.5), 0.0, 0.0]), 0.001, 1000)
    assert body.arrays["failed"].all()
    assert body.state_warning() is None


def pulled(distance):
    """A strip whose ends are led apart."""
    table = sheet(edges=((2, 0, 0), (0, 0.5, 0)), points=(21, 6))
    table |= {"thickness": 0.01, "damping": 50.0}
    motions = [
        {
            "name": name,
            "body": "sheet",
            "part": {"box": {"lower": [x - 0.03, -9, -9], "upper": [x + 0.03, 9, 9]}},
            "hold": ["y", "z"],
            "displacement": {"x": {"kind": "ramp", "distance": way * distance, "duration": 1.0}},
        }
        for name, x, way in (("left", -0.99, -1.0), ("right", 1.01, 1.0))
    ]
    grid = {"counts": (32, 6, 6), "cell": CELL, "lower": (-4.0, -0.75, -0.75)}
    return Simulation(case(table, **grid, motion=motions, end=1.0), threads=1)


def run(sim):
    while not sim.clock.finished(None):
        sim.step()


def test_a_run_warns_once():
    sim = pulled(2.0)
    with pytest.warns(UserWarning, match=r"step \d+, time .* s: membrane sheet is torn") as told:
        run(sim)
    assert sim.n_steps > 5 * WARNING_INTERVAL
    assert sum("torn" in str(warning.message) for warning in told) == 1
    assert "state of sheet" in sim.state_numbers()["warned"]


def test_a_strip_that_holds_does_not_warn():
    with warnings.catch_warnings():
        warnings.filterwarnings("error", message=".*torn")
        run(pulled(0.3))
