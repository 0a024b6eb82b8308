"""What the drop's metrics measure, on states that are known."""

from types import SimpleNamespace

import numpy as np
import pytest

from pellucid.case import load
from pellucid.gallery.lian2014 import water_drop

CASE = load("lian2014/water-drop")
FLAT = np.array([(x, y, 0.0) for x in np.linspace(0.0, 0.025, 6) for y in np.linspace(0.0, 0.025, 6)])
TILTED = FLAT * (1.0, 1.0, 0.0) + FLAT[:, :1] * (0.0, 0.0, 0.1)  # z = x/10


class Still:
    """A run that stands still: some points of the drop, of one mass each if nothing else is said, and the sheet."""

    case = SimpleNamespace(grid=CASE.grid)

    def __init__(self, drop, sheet=FLAT, mass=None):
        drop = np.array(drop, float).reshape(-1, 3)
        self.bodies = {
            "sheet": {"position": sheet},
            "drop": {"position": drop, "mass": np.ones(len(drop)) if mass is None else np.array(mass, float)},
        }

    def fields(self, body, time=None):
        return self.bodies[body]


@pytest.mark.parametrize(
    ("sheet", "points", "share"),
    [
        (FLAT, [(0.001, 0.001, 0.001), (0.02, 0.001, 1e-6)], 0.0),
        (FLAT, [(0.001, 0.001, 0.001), (0.02, 0.001, -1e-6)], 0.5),
        (TILTED, [(0.001, 0.001, 0.00011), (0.011, 0.003, 0.00111)], 0.0),
        (TILTED, [(0.001, 0.001, 0.00009), (0.011, 0.003, 0.00111)], 0.5),
        (FLAT, [(0.001, 0.001, 0.001), (0.0251, 0.001, 0.001)], 0.5),  # beside the sheet
    ],
)
def test_points_below_the_sheet(sheet, points, share):
    assert water_drop.below(Still(points, sheet), 0.0) == share


def test_radius_is_that_of_the_remotest_point_from_the_axis():
    assert water_drop.radius(Still([(0.003, 0.004, 0.1), (0.001, 0.0, 0.0)]), 0.0) == pytest.approx(0.005)


def chain(start, n, step):
    """n points along x."""
    return [(start + step * i, 0.0004, 0.001) for i in range(n)]


def test_points_hang_together_up_to_a_cell():
    cell = CASE.grid.cell
    assert water_drop.broken(Still(chain(0.0, 10, 0.99 * cell)), 0.0) == 0.0
    torn = chain(0.0, 6, 0.99 * cell) + chain(0.005 + 1.01 * cell, 4, 0.9 * cell)
    assert water_drop.broken(Still(torn), 0.0) == pytest.approx(0.4)


def test_pieces_are_weighed_and_those_across_the_planes_are_one():
    cell = CASE.grid.cell
    far = [(10 * cell, 10 * cell, 0.0), (10.5 * cell, 10 * cell, 0.0)]
    middle = [(0.4 * cell, 0.4 * cell, 0.0)]  # its images are 0.8 cells from it: one piece, four times as heavy
    assert water_drop.broken(Still(far + middle, mass=[1.0, 1.0, 1.0]), 0.0) == pytest.approx(2.0 / 3.0)
    assert water_drop.broken(Still(far + middle, mass=[1.0, 1.0, 9.0]), 0.0) == pytest.approx(2.0 / 11.0)
    beside = [(0.6 * cell, 0.6 * cell, 0.0)]  # its images are 1.2 cells from it: four pieces
    assert water_drop.broken(Still(far + beside, mass=[1.0, 1.0, 1.9]), 0.0) == pytest.approx(1.9 / 3.9)
