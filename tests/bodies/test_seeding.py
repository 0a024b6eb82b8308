"""Seeding: where points stand, and that their volumes are the shape's."""

import numpy as np
import pytest
from scenes import box, case, simulation

from pellucid.bodies.seeding import points_along_axes, seed
from pellucid.geometry.shapes import Box, Cylinder, Sphere

SHAPES = {
    "box": Box(lower=(0.5, 0.75, 1.0), upper=(3.5, 3.0, 2.0)),
    "ball": Sphere(centre=(2.0, 1.9, 2.1), radius=1.7),
    "disc": Cylinder(centre=(2.0, 2.0, 2.0), radius=1.5, height=2.0),
}
COUNTS = {"3-D": (4, 4, 4), "2-D": (4, 4, 1), "1-D": (4, 1, 1)}


def grid(counts, cell=1.0):
    return case(box((0, 0, 0), (cell, cell, cell)), counts=counts, cell=cell).grid


@pytest.mark.parametrize("shape", SHAPES.values(), ids=SHAPES)
@pytest.mark.parametrize("counts", COUNTS.values(), ids=COUNTS)
def test_volumes_sum_to_the_shape(shape, counts):
    active = tuple(n > 1 for n in counts)
    per_cell = tuple(3 if a else 1 for a in active)
    points, volumes = seed(shape, grid(counts), per_cell)
    assert volumes.sum() == pytest.approx(shape.measure(active), rel=1e-13)  # thin axes are 1 m thick
    assert np.all(volumes == volumes[0])
    assert shape.contains(points, active).all()
    for axis in range(3):
        if not active[axis]:
            assert np.all(points[:, axis] == 0.5), "in the middle of the thin cell"


def test_a_box_is_filled_evenly_though_it_fits_no_cells():
    shape = Box(lower=(0.1, 0.0, 0.0), upper=(3.45, 1.0, 1.0))
    points, _ = seed(shape, grid((4, 1, 1)), (2, 1, 1))
    x = np.sort(points[:, 0])
    assert len(x) == 7  # 3.35 m in halves of a cell
    assert np.diff(x) == pytest.approx(np.full(6, 3.35 / 7))
    assert x[0] - 0.1 == pytest.approx(3.35 / 14)


def test_points_per_cell():
    box_of_cells = Box(lower=(0, 0, 0), upper=(2, 3, 4))
    points, _ = seed(box_of_cells, grid((4, 4, 4)), (1, 2, 3))
    assert len(points) == 2 * 6 * 12
    # no two points in one place
    assert len(np.unique(points.round(9), axis=0)) == len(points)


def test_a_box_thinner_than_a_point_gets_one_layer():
    points, volumes = seed(Box(lower=(1, 1, 1), upper=(1.01, 2, 2)), grid((4, 4, 4)), (2, 2, 2))
    assert len(points) == 4
    assert volumes.sum() == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("number", "thin", "along"),
    [
        (8, (False, False, False), (2, 2, 2)),
        (27, (False, False, False), (3, 3, 3)),
        (9, (False, True, False), (3, 1, 3)),
        (25, (False, True, True), (25, 1, 1)),
        ((2, 3, 4), (False, True, False), (2, 3, 4)),
        (1, (False, False, False), (1, 1, 1)),
        (1000000, (False, False, False), (100, 100, 100)),
    ],
)
def test_a_number_of_points_is_shared_among_the_axes(number, thin, along):
    assert points_along_axes(number, thin) == along


def test_a_number_that_cannot_be_shared_says_which_can():
    with pytest.raises(ValueError, match="use one of 1, 4, 9, 16, 25"):
        points_along_axes(8, (False, False, True))


def test_initial_velocities():
    """v + w × (x - centre) + a sin(k·x + φ), nothing along thin axes."""
    wave = {"amplitude": (0.1, 0.2, 0.3), "wave_vector": (1.0, 2.0, 0.0), "phase": 0.5}
    body = box((1, 1, 0), (3, 3, 1), velocity=(1, 2, 3), angular_velocity=(0.1, 0.2, 0.3), velocity_wave=wave)
    frame = simulation(body, counts=(4, 4, 1)).bodies[0].frame()
    x = frame["position"]
    expected = np.array((1.0, 2.0, 3.0)) + np.cross((0.1, 0.2, 0.3), x - (2.0, 2.0, 0.5))
    expected += np.sin(x @ (1.0, 2.0, 0.0) + 0.5)[:, None] * (0.1, 0.2, 0.3)
    expected[:, 2] = 0.0
    assert frame["velocity"] == pytest.approx(expected, abs=1e-14)
