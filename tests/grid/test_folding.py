"""Periodic grids: which nodes are the same, and where places lie within the box."""

import numpy as np
import pytest

from pellucid.approximants import GRID_FUNCTIONS, grid_functions
from pellucid.approximants.grid_functions import axis_weights
from pellucid.contact.detection import allocate_numbers, mark_stencils
from pellucid.grid.folding import Walled, beyond_span, in_period
from pellucid.grid.lattice import Grid, row_edges
from pellucid.grid.model import GridCase
from pellucid.grid.passes.places import in_cells
from pellucid.grid.points import cell_at
from pellucid.grid.sorting import slabs_of
from pellucid.grid.stencil import node_at, stencil

every_function = pytest.mark.parametrize("functions", GRID_FUNCTIONS)
COUNTS = (5, 4, 7)


def grid_of(functions="quadratic-bspline", periodic=("x", "z"), counts=COUNTS, cell=0.5):
    upper = [1.0 + n * cell for n in counts]
    case = GridCase(lower=(1, 1, 1), upper=upper, cell=cell, functions=functions, periodic=periodic)
    return case, Grid(case), grid_functions(functions, (2, 2, 2), case.thin(), case.is_periodic())


def weights_about(grid, functions, place):
    """Of all nodes, shape (nodes,), and their gradients, shape (nodes, 3), summed where a stencil names one twice."""
    about = stencil(functions, grid.lattice, np.array([place]), 0)
    values, slopes = np.zeros(grid.n_nodes), np.zeros((grid.n_nodes, 3))
    for a, (w, s) in enumerate(zip(about.wx, about.gx, strict=True)):
        for b, (u, t) in enumerate(zip(about.wy, about.gy, strict=True)):
            for c, (v, r) in enumerate(zip(about.wz, about.gz, strict=True)):
                I = int(node_at(about, grid.lattice, a, b, c))
                values[I] += w * u * v
                slopes[I] += np.array((s * u * v, w * t * v, w * u * r)) / grid.lattice.cell
    return values, slopes


@every_function
def test_places_a_period_apart_have_the_same_nodes(functions):
    _, grid, along = grid_of(functions)
    index = set(grid.where()[0].tolist())
    for place in np.random.default_rng(1).uniform(1.0, 3.0, (40, 3)):
        values, slopes = weights_about(grid, along, place)
        assert set(np.flatnonzero(values).tolist()) <= index
        assert values.sum() == pytest.approx(1.0, abs=1e-14)
        assert slopes.sum(axis=0) == pytest.approx(np.zeros(3), abs=1e-13)
        there = weights_about(grid, along, np.add(place, (3 * 2.5, 0.0, -2 * 3.5)))
        assert there[0] == pytest.approx(values, abs=1e-14)
        assert there[1] == pytest.approx(slopes, abs=1e-13)


@every_function
def test_waves_across_the_seam_are_as_smooth_as_elsewhere(functions):
    """The field of the nodes moved by a cell is that of the places moved by one."""
    _, grid, along = grid_of(functions)
    index, position = grid.where()
    wave = np.zeros((2, grid.n_nodes))
    for k, moved in enumerate((0.0, 0.5)):
        wave[k, index] = np.sin(2.0 * np.pi * (position[:, 0] - moved) / 2.5) * np.cos(2.0 * np.pi * position[:, 2] / 3.5)
    for place in np.random.default_rng(2).uniform(1.0, 3.0, (20, 3)):
        here, there = (weights_about(grid, along, x)[0] for x in (place, np.add(place, (0.5, 0.0, 0.0))))
        assert here @ wave[0] == pytest.approx(there @ wave[1], abs=1e-14)


def test_a_node_stands_once_on_a_periodic_axis():
    _, grid, _ = grid_of()
    index, position = grid.where()
    assert len(np.unique(index)) == len(index) == 5 * 5 * 7
    assert position.max(axis=0).tolist() == [3.0, 3.0, 4.0]
    assert grid.real_nodes(index).tolist() == index.tolist()
    assert grid.lattice.slab_axis == 1  # whose rows do not meet


def test_without_periodic_axes_nothing_is_folded():
    assert isinstance(Grid(GridCase(lower=(0, 0, 0), upper=(4, 4, 4), cell=1)).lattice.folding, Walled)


@every_function
def test_stencils_that_hold_a_node_are_found_across_the_seam(functions):
    _, grid, along = grid_of(functions)
    slot, near = allocate_numbers(grid.n_nodes)
    node = grid.where()[0][[0, 3, 100, 174]]
    mark_stencils(node, slot, near, tuple(function.stencil for function in along), grid.lattice, True)
    for place in np.random.default_rng(3).uniform(1.0, 3.0, (100, 3)) * [1.2, 1.0, 1.4]:
        about = stencil(along, grid.lattice, np.array([place]), 0)
        named = {int(node_at(about, grid.lattice, *way)) for way in np.ndindex(*(function.stencil for function in along))}
        if named & set(node.tolist()):
            assert near[about.start] == 1


def test_places_are_folded_into_the_box():
    _, grid, _ = grid_of()
    lattice = grid.lattice
    assert in_cells(lattice, (1.0 - 0.25, 1.25, 1.0 + 3.5)) == pytest.approx((4.5, 0.5, 0.0))
    assert cell_at(lattice, (1.0 - 0.25, 1.25, 4.6)) == cell_at(lattice, (3.3, 1.25, 1.1))
    assert in_period(lattice.folding, 1, -0.5) == -0.5


@pytest.mark.parametrize(("u", "beyond"), [(3.5, 0), (6.1, 0), (1.1, 0), (8.0, 0), (1.3, 1), (2.4, 1), (-2.6, 1)])
def test_points_leave_a_slab_at_the_seam_as_elsewhere(u, beyond):
    """Of five cells: a slab that reaches from 2.5 to 6.2 ends at 1.2."""
    assert beyond_span(grid_of()[1].lattice.folding, 0, u, 2.5, 6.2) == beyond


@pytest.mark.parametrize(("layers", "rows"), [(4, 1), (6, 2), (9, 2), (10, 2), (12, 4), (64, 20)])
def test_rows_across_a_seam_are_even_in_number(layers, rows):
    """Or there is one alone, so that neighbours are of two colours."""
    edges = row_edges(layers, 2, 64, periodic=True)
    assert len(edges) - 1 == rows
    assert rows == 1 or np.diff(edges).min() >= 3


@every_function
def test_slabs_of_one_colour_share_no_node(functions):
    """Wherever their points may go before they are sorted again."""
    case, grid, along = grid_of(functions, ("x", "y", "z"), (22, 24, 23), 1.0)
    slabs, lattice = slabs_of(grid.lattice, along), grid.lattice
    reached = []
    for low, high, left, right in slabs.bounds:
        ends = {lattice.slab_axis: (low, high - 1e-9), lattice.cut_axis: (left, right - 1e-9)}
        axes = []
        for axis in (0, 1, 2):
            a, b = ends.get(axis, (0.0, 1.0))
            n = case.counts()[axis]
            steps = np.linspace(a, b, 300) if np.isfinite(a) else np.arange(n + 0.0)
            first = {int(axis_weights(along[axis], u, n)[0]) for u in steps}
            axes.append({(i + k) % n for i in first for k in range(along[axis].stencil)})
        reached.append([axes[lattice.slab_axis], axes[lattice.cut_axis]])
    across = slabs.across
    for s in range(len(reached)):
        for t in range(s):
            same = (s // across - t // across) % 2 == 0 and (s % across - t % across) % 2 == 0
            meet = all(bool(one & other) for one, other in zip(reached[s], reached[t], strict=True))
            assert not (same and meet), (s, t)
