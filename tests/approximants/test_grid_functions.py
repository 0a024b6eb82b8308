"""Partition of unity, linear reproduction, gradients and walls, for every grid function that is registered."""

import numpy as np
import pytest

from pellucid.approximants import GRID_FUNCTIONS, grid_functions
from pellucid.approximants.grid_functions import Gimp, affine_weights, axis_weights
from pellucid.grid.lattice import LARGEST_STENCIL, PAD

ROUNDING = 1e-12  # a few dozen operations on numbers of order one
COUNTS = (1, 2, 3, 4, 7, 50)
PER_CELL = (1, 2, 3, 25)


def registered():
    for name, make in GRID_FUNCTIONS.items():
        for function in dict.fromkeys(make(per_cell) for per_cell in PER_CELL):
            yield pytest.param(function, id=f"{name}-{getattr(function, 'half', 'all')}")


every_function = pytest.mark.parametrize("fn", list(registered()))
every_count = pytest.mark.parametrize("n", COUNTS)


def places(n):
    """Coordinates in cells: at random, on every node and middle, and as close to them as numbers go."""
    marks = np.arange(0.0, n + 0.25, 0.25)
    near = [np.nextafter(marks, -np.inf), np.nextafter(marks, np.inf)]
    near += [marks + sign * distance for distance in (1e-12, 2e-8, 1e-6, 1.1e-4, 1e-3) for sign in (-1.0, 1.0)]
    found = np.concatenate([np.random.default_rng(n).uniform(0.0, n, 50), marks, *near, [5e-324]])
    return [float(u) for u in found if 0.0 <= u <= n]


def at(fn, u, n):
    """Nodes, weights and derivatives as arrays."""
    first, w, g = axis_weights(fn, u, n)
    return first + np.arange(len(w)), np.array(w), np.array(g)


@every_function
@every_count
def test_partition_of_unity(fn, n):
    for u in places(n):
        _, w, g = at(fn, u, n)
        assert abs(w.sum() - 1.0) < ROUNDING, u
        assert abs(g.sum()) < ROUNDING, u


@every_function
@every_count
def test_no_weight_reaches_farther_than_half_the_stencil(fn, n):
    for u in places(n):
        nodes, w, _ = at(fn, u, n)
        assert np.abs(nodes - u)[w != 0.0].max() <= 0.5 * fn.stencil * (1.0 + ROUNDING), u


@every_function
@every_count
def test_linear_fields_are_reproduced(fn, n):
    for u in places(n):
        nodes, w, g = at(fn, u, n)
        assert abs(w @ nodes - u) < ROUNDING * max(n, 1), u
        assert abs(g @ nodes - 1.0) < ROUNDING * max(n, 1), u


@every_function
@every_count
def test_derivatives_are_those_of_the_weights(fn, n):
    step = 1e-6
    for u in np.random.default_rng(n).uniform(2.0 * step, n - 2.0 * step, 100):
        values = np.zeros((2, n + PAD + LARGEST_STENCIL))
        for row, place in enumerate((u - step, u + step)):
            nodes, w, _ = at(fn, place, n)
            values[row, nodes] = w
        nodes, _, g = at(fn, float(u), n)
        # the functions are quadratic or cubic with second derivatives up to 1/l = 50, and a kink (never met here) at most
        assert (values[1] - values[0])[nodes] / (2.0 * step) == pytest.approx(g, abs=50.0 * step), u


@every_function
@every_count
def test_weights_are_never_negative(fn, n):
    for u in places(n):
        assert at(fn, u, n)[1].min() >= -1e-15, u  # else a node could have negative mass; rounding of 1 - 1


@every_function
@every_count
def test_the_wall_is_interpolated(fn, n):
    for u, wall in ((0.0, 0), (float(n), n)):
        nodes, w, _ = at(fn, u, n)
        assert w[nodes == wall] == pytest.approx(1.0, abs=ROUNDING)
        assert np.abs(w[nodes != wall]).max() < ROUNDING


@every_function
@every_count
def test_nothing_lies_beyond_the_walls(fn, n):
    for u in places(n):
        nodes, w, g = at(fn, u, n)
        beyond = nodes > n
        assert not w[beyond].any(), u
        assert not g[beyond].any(), u
        assert nodes[0] >= 0, u
        assert nodes[-1] < max(n + PAD, LARGEST_STENCIL), "the stencil stays in the memory of the grid"


@every_function
def test_the_stencil_has_the_stated_length(fn):
    _, w, g = axis_weights(fn, 0.3, 4)
    assert len(w) == len(g) == fn.stencil <= LARGEST_STENCIL


@every_function
def test_functions_are_continuous_across_cells(fn):
    n = 6
    for mark in np.arange(0.5, n, 0.5):
        values = np.zeros((2, n + PAD + LARGEST_STENCIL))
        for row, u in enumerate((np.nextafter(mark, 0.0), np.nextafter(mark, n))):
            nodes, w, _ = at(fn, float(u), n)
            values[row, nodes] = w
        assert np.abs(values[0] - values[1]).max() < ROUNDING, mark


@every_function
def test_the_grid_looks_the_same_from_both_walls(fn):
    n = 5
    for u in np.random.default_rng(0).uniform(0.0, n, 50):
        values = np.zeros((2, n + 1))
        for row, place in enumerate((u, n - u)):
            nodes, w, _ = at(fn, float(place), n)
            np.add.at(values[row], np.minimum(nodes, n), w)
        assert values[0] == pytest.approx(values[1][::-1], abs=ROUNDING)


@every_function
@every_count
def test_affine_weights_give_the_gradient_of_linear_fields(fn, n):
    for u in places(n):
        first, w, g = axis_weights(fn, u, n)
        b = np.array(affine_weights(fn, first - u, w, g))
        nodes = first + np.arange(len(w))
        # divided by the spread of the weights, at least 1e-4: four digits fewer, of numbers near 1e-16
        assert abs(b.sum()) < 10.0 * ROUNDING, u
        assert abs(b @ (nodes - u) - 1.0) < 10.0 * ROUNDING, u
        assert not b[nodes > n].any(), u


def test_gimp_with_one_point_a_cell_is_the_quadratic_spline():
    """Tents averaged over a whole cell are quadratic B-splines, walls apart (Steffen, Kirby & Berzins 2008)."""
    n = 9
    for u in np.random.default_rng(1).uniform(1.0, n - 1.0, 50):
        values = np.zeros((2, n + PAD + LARGEST_STENCIL))
        for row, fn in enumerate((Gimp(0.5), GRID_FUNCTIONS["quadratic-bspline"](1))):
            nodes, w, _ = at(fn, float(u), n)
            values[row, nodes] = w
        assert values[0] == pytest.approx(values[1], abs=ROUNDING)


def test_gimp_of_small_points_is_trilinear_away_from_nodes():
    n, half = 4, 1e-3
    for u in (0.5, 1.25, 3.75):
        nodes, w, g = at(Gimp(half), u, n)
        first, tent, slope = axis_weights(GRID_FUNCTIONS["trilinear"](1), u, n)
        inside = (nodes >= first) & (nodes < first + 2)
        assert w[inside] == pytest.approx(tent, abs=ROUNDING)
        assert g[inside] == pytest.approx(slope, abs=ROUNDING)


@pytest.mark.parametrize("name", GRID_FUNCTIONS)
@pytest.mark.parametrize("per_cell", [1, 2, 5])
def test_quadrature_of_gradients_vanishes_inside(name, per_cell):
    """A full lattice of points under uniform stress must not push the nodes inside."""
    n = 8
    fn = GRID_FUNCTIONS[name](per_cell)
    push = np.zeros(n + PAD + LARGEST_STENCIL)
    for u in (np.arange(n * per_cell) + 0.5) / per_cell:
        nodes, _, g = at(fn, float(u), n)
        push[nodes] += g / per_cell
    assert np.abs(push[2 : n - 1]).max() < ROUNDING
    # and the walls carry all of it
    assert push[:2].sum() == pytest.approx(-1.0, abs=ROUNDING)


def test_thin_axes_are_flat():
    """One node that takes everything: a slab is a plane, a tube a line."""
    x, y, z = grid_functions("cubic-bspline", (2, 2, 1), (False, False, True))
    assert (x.stencil, y.stencil, z.stencil) == (4, 4, 1)
    assert axis_weights(z, 0.3, 1) == (0, (1.0,), (0.0,))
