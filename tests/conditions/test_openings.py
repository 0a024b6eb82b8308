"""Openings in faces of the grid: their columns and nodes, and velocities across them."""

import numpy as np
import pytest

from pellucid.approximants import GRID_FUNCTIONS, grid_functions
from pellucid.approximants.grid_functions import axis_weights
from pellucid.conditions.open_faces.columns import OpenFace, columns, why_apart
from pellucid.conditions.open_faces.given_flow import across_tube, across_walls
from pellucid.conditions.open_faces.strip import layers, nodes_across
from pellucid.geometry.shapes.solids import Box, Cylinder
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase

CASE = GridCase(lower=(-1.0, 0.0, 0.0), upper=(2.0, 2.0, 1.5), cell=0.25)


@pytest.mark.parametrize("name", GRID_FUNCTIONS)
@pytest.mark.parametrize("face", ["x-lower", "x-upper"])
def test_led_nodes_are_all_that_points_in_the_cells_reach(name, face):
    grid, function = Grid(CASE), GRID_FUNCTIONS[name](2)
    led, n = layers(grid, function, OpenFace.of(face, CASE)), 12
    for place in np.random.default_rng(1).uniform(0.0, 1.0, 50):
        first, weights, _ = axis_weights(function, place if face == "x-lower" else n - place, n)
        reached = first + np.flatnonzero(np.abs(weights) > 1e-12)
        assert set(reached) <= set(led)


@pytest.mark.parametrize("face", ["x-lower", "x-upper"])
def test_columns_fill_the_opening(face):
    tube = Cylinder(centre=(0.5, 1.0, 0.75), radius=0.6, axis="x", height=3.0)
    found = columns(tube, (), None, CASE, OpenFace.of(face, CASE))
    assert found.spacing == 0.125
    assert found.area.sum() == pytest.approx(np.pi * 0.36, rel=0.01)
    assert (found.depth > 0.0).all()
    assert (found.depth < found.spacing).all()
    assert np.abs(found.place[:, 0] - (-1.0 if face == "x-lower" else 2.0)).max() < found.spacing


def test_a_shape_that_does_not_reach_the_face_has_none():
    block = Box(lower=(0.0, 0.0, 0.0), upper=(1.0, 1.0, 1.0))
    assert columns(block, (), None, CASE, OpenFace.of("x-lower", CASE)).n == 0


def test_an_opening_ends_where_the_face_does():
    reaching_over = Box(lower=(-2.0, -0.5, -0.5), upper=(3.0, 1.0, 4.0))
    found = columns(reaching_over, (), None, CASE, OpenFace.of("x-lower", CASE))
    assert found.area.sum() == pytest.approx(1.0 * 1.5)
    assert (found.place[:, 1:] > 0.0).all()
    assert (found.place[:, 2] < 1.5).all()


def test_an_opening_goes_on_across_a_seam():
    case = CASE.model_copy(update={"periodic": ("y",)})
    face, across = OpenFace.of("x-lower", case), Box(lower=(-2.0, -0.5, 0.0), upper=(3.0, 0.5, 1.5))
    assert why_apart("the opening", across, face, case) is None
    assert columns(across, (), None, case, face).area.sum() == pytest.approx(1.0 * 1.5)
    assert why_apart("the opening", Box(lower=(-2.0, 2.5, 0.0), upper=(3.0, 3.0, 1.5)), face, case) is None


@pytest.mark.parametrize("periodic", [(), ("y",)], ids=["walls", "periodic"])
@pytest.mark.parametrize("name", GRID_FUNCTIONS)
def test_columns_see_what_nodes_across_have(name, periodic):
    """A linear field between walls; across a seam a constant one."""
    case = CASE.model_copy(update={"periodic": periodic})
    grid, functions = Grid(case), grid_functions(name, (2, 2, 2), case.thin(), case.is_periodic())
    face = OpenFace.of("x-lower", case)
    found = columns(Box(lower=(-1.0, 0.0, 0.0), upper=(2.0, 2.0, 1.5)), (), None, case, face)
    across = nodes_across(found, grid, functions, face)
    slope = 0.0 if periodic else 3.0
    seen = across.at_columns(1.0 + slope * across.place[:, 1] - 2.0 * across.place[:, 2], found.n)
    assert seen == pytest.approx(1.0 + slope * found.place[:, 1] - 2.0 * found.place[:, 2], abs=1e-12)
    assert len(set(across.stored)) == len(across.stored)
    index, place = grid.where()
    at = np.searchsorted(np.sort(index), across.stored)
    assert place[np.argsort(index)[at], 1:] == pytest.approx(across.place[:, 1:])


def test_velocities_across_a_duct_are_those_of_its_series():
    """Of a square one the mean is 0.140577 and the largest 0.294685 of f a²/μ, of half a side a."""
    place = np.zeros((201 * 201, 3))
    place[:, 1:] = np.stack(np.meshgrid(*2 * [np.linspace(-1.0, 1.0, 201)]), axis=-1).reshape(-1, 2)
    share = across_walls([None, (-1.0, 1.0), (-1.0, 1.0)], place)
    ends = np.full(201, 1.0)
    ends[[0, -1]] = 0.5
    mean = float(np.outer(ends, ends).ravel() @ share) / 200**2
    assert share.max() / mean == pytest.approx(0.294685 / 0.140577, rel=2e-4)
    assert share.min() >= 0.0


def test_velocities_across_slits_and_tubes_are_parabolas():
    y = np.linspace(-1.5, 1.5, 31)
    place = np.stack([np.zeros(31), y, np.zeros(31)], axis=1)
    assert across_walls([None, (-1.0, 1.0), None], place) == pytest.approx(np.maximum(1.0 - y * y, 0.0))
    tube = Cylinder(centre=(5.0, 0.0, 0.0), radius=1.0, axis="x", height=1.0)
    assert across_tube(tube, 0, place) == pytest.approx(np.maximum(1.0 - y * y, 0.0))
