"""Surfaces that cross, touch, or do neither."""

import numpy as np
import pytest

from pellucid.geometry.algorithms.crossing import crossing
from pellucid.geometry.surfaces.surface import Surface


def sheet(corner, first, second, points=(6, 7)):
    """Triangles of a rectangle."""
    table = {"rectangle": {"corner": corner, "first_edge": first, "second_edge": second, "points": points}}
    return Surface.model_validate(table).triangulate()


def ball(radius):
    """Triangles of a sphere about the origin."""
    return Surface.model_validate({"sphere": {"centre": (0, 0, 0), "radius": radius, "divisions": 5}}).triangulate()


FLAT = sheet((-1, -1, 0), (2, 0, 0), (0, 2, 0))


@pytest.mark.parametrize(
    "other",
    [
        sheet((-0.31, -0.5, -0.6), (0, 1, 0), (0, 0, 1.1)),  # upright, through it
        sheet((-0.03, -0.02, -0.01), (0.02, 0, 0), (0, 0, 0.02), (2, 2)),  # smaller than a triangle
        sheet((-0.31, -0.5, 0), (0, 1, 0), (0, 0, 1.1)),  # stands on it
        sheet((-0.43, -0.57, 0), (1, 0, 0), (0, 1, 0), (4, 3)),  # lies in it
        ball(0.7),
    ],
)
def test_surfaces_that_meet_are_found_with_a_place_on_both(other):
    for one, two in ((FLAT, other), (other, FLAT)):
        place = crossing(one, two)
        assert place is not None
        assert place[2] == pytest.approx(0.0, abs=1e-9)
        assert np.abs(place).max() <= 1.0


@pytest.mark.parametrize(
    "other",
    [
        sheet((-1, -1, 1e-3), (2, 0, 0), (0, 2, 0)),
        sheet((1.01, -1, -0.5), (0, 2, 0), (0, 0, 1)),
        sheet((0.5, 0.5, 1e-3), (0.3, 0, 0), (0, 0, 0.5)),
    ],
)
def test_surfaces_that_stay_apart_are_not(other):
    assert crossing(FLAT, other) is None
    assert crossing(other, FLAT) is None


def test_one_inside_another_is_no_crossing():
    assert crossing(ball(0.5), ball(0.7)) is None
    assert crossing(ball(0.7), ball(0.71)) is None
