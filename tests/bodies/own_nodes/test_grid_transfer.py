"""A body's own nodes on the grid: an index by cell in place of sorting, and nothing else changes."""

import numpy as np
import pytest
from small_cases import box, case

from pellucid.approximants import grid_functions
from pellucid.bodies.own_nodes.grid_transfer import GridCoupling
from pellucid.grid.lattice import Grid
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.grid.points import LOST

COUNTS, CELL, LOWER = (5, 20, 4), 0.5, (-1.0, 2.0, 0.5)
N = 400
GRADIENT = np.array([[0.3, -0.2, 0.5], [0.1, -0.4, 0.2], [-0.6, 0.7, 0.2]])
every_function = pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline", "gimp"])


def nodes_at_random():
    """Places, velocities and masses of nodes in no order; some on the faces of the grid."""
    generator = np.random.default_rng(8)
    inside = generator.random((N, 3))
    inside[generator.random(inside.shape) < 0.05] = 0.0
    position = np.array(LOWER) + inside * np.array(COUNTS) * CELL
    return position, generator.normal(size=(N, 3)), generator.uniform(0.5, 2.0, N)


def coupled(position, velocity, mass, functions="trilinear"):
    whole = case(box(LOWER, np.array(LOWER) + 0.5), counts=COUNTS, cell=CELL, lower=LOWER, functions=functions)
    field = OwnNodesField("own", Grid(whole.grid))
    return GridCoupling(field, grid_functions(functions, (2, 2, 2), field.grid.thin), position, velocity, mass)


def order_of(coupling):
    """In which the index counts the nodes."""
    return coupling.state_arrays()["order"].copy()


def scattered(coupling, force):
    """What the nodes of the grid have after the scatter."""
    nodes = coupling.velocity_field.grid.nodes
    coupling.velocity_field.clear()
    coupling.scatter(force)
    return nodes.mass.copy(), nodes.momentum.copy(), nodes.force.copy()


@every_function
def test_nodes_in_any_order_give_and_take_what_sorted_ones_do(functions):
    """To the last bit: the index counts them in the order of the sorted ones, cell by cell."""
    given, force = nodes_at_random(), np.random.default_rng(9).normal(size=(N, 3))
    kept = [array.copy() for array in given]
    free = coupled(*given, functions)
    order = order_of(free)
    assert not np.array_equal(order, np.arange(N))
    in_order = coupled(*(array[order].copy() for array in given), functions)
    assert np.array_equal(order_of(in_order), np.arange(N))
    assert free.n_slabs == in_order.n_slabs > 2
    for one, other in zip(scattered(free, force), scattered(in_order, force[order]), strict=True):
        assert one.any()
        assert one.tobytes() == other.tobytes()
    increment = np.random.default_rng(10).normal(size=free.velocity_field.grid.nodes.velocity.shape)
    for coupling in (free, in_order):
        coupling.velocity_field.grid.nodes.velocity_increment[:], coupling.velocity_field.pressed = increment, True
    assert free.gather().any()
    assert np.array_equal(free.gather()[order], in_order.gather())
    for array, before in zip(given, kept, strict=True):
        assert np.array_equal(array, before), "the body's arrays are left as they are"


@every_function
def test_mass_momentum_and_forces_arrive(functions):
    position, velocity, mass = nodes_at_random()
    force = np.random.default_rng(9).normal(size=(N, 3))
    coupling = coupled(position, velocity, mass, functions)
    m, p, f = scattered(coupling, force)
    index, where = coupling.velocity_field.grid.where()
    # sums of some hundred numbers of order one; positions of order ten
    assert m.sum() == pytest.approx(mass.sum(), rel=1e-13)
    assert p.sum(axis=0) == pytest.approx(mass @ velocity, abs=1e-12 * mass.sum())
    assert f.sum(axis=0) == pytest.approx(force.sum(axis=0), abs=1e-12 * N)
    assert m[index] @ where == pytest.approx(mass @ position, rel=1e-13)
    assert f[index].T @ where == pytest.approx(force.T @ position, abs=1e-12 * N * 10.0)


@every_function
def test_momentum_alone_is_that_of_the_velocities_now(functions):
    position, velocity, mass = nodes_at_random()
    coupling = coupled(position, velocity, mass, functions)
    before, momentum, _ = scattered(coupling, None)
    velocity *= -2.0
    coupling.scatter_momentum()
    nodes = coupling.velocity_field.grid.nodes
    assert nodes.momentum == pytest.approx(-2.0 * momentum, abs=1e-13 * np.abs(momentum).max())
    assert np.array_equal(nodes.mass, before)
    assert not nodes.force.any()


@every_function
def test_a_linear_increment_is_gathered_exactly(functions):
    position, velocity, mass = nodes_at_random()
    coupling = coupled(position, velocity, mass, functions)
    index, where = coupling.velocity_field.grid.where()
    coupling.velocity_field.grid.nodes.velocity_increment[index] = where @ GRADIENT.T + (1.0, -2.0, 3.0)
    assert not coupling.gather().any(), "contact gave nothing"
    coupling.velocity_field.pressed = True
    assert coupling.gather() == pytest.approx(position @ GRADIENT.T + (1.0, -2.0, 3.0), abs=1e-13)
    assert np.array_equal(coupling.increment, coupling.gather())


def walked(coupling, position, steps):
    """Let the nodes drift through several cells, the index renewed where one left its slab; how often it was."""
    renewed, drift = 0, 0.1 * CELL * np.sign(LOWER[1] + 0.5 * COUNTS[1] * CELL - position[:, 1])
    for _ in range(steps):
        position[:, 1] += drift
        assert coupling.check_positions() is None
        coupling.slabs.sums[0, 0] = 1.0  # until they are sorted again
        coupling.sort_if_needed()
        renewed += coupling.slabs.sums[0, 0] == 0.0
    return renewed


def test_the_index_is_renewed_where_nodes_left_their_slabs_alone():
    position, velocity, mass = nodes_at_random()
    coupling = coupled(position, velocity, mass)
    assert coupling.check_positions() is None
    assert walked(coupling, position.copy(), 1) == 0
    assert 0 < walked(coupling, position, 25) < 25
    coupling.sort()
    layers = np.floor((position - LOWER) / CELL).astype(int)[order_of(coupling), 1]
    assert np.all(np.diff(layers) >= 0), "y is the longest axis, along which slabs are cut"


def test_a_restored_index_gives_the_same_bits():
    """It depends on the way that the nodes went: an index made anew would add them up in another order."""
    position, velocity, mass = nodes_at_random()
    one = coupled(position, velocity, mass)
    assert walked(one, position, 25)
    force = np.random.default_rng(9).normal(size=(N, 3))
    late = coupled(position, velocity, mass)
    assert not np.array_equal(order_of(late), order_of(one))
    late.restore({name: array.copy() for name, array in one.state_arrays().items()})
    for name, array in one.state_arrays().items():
        assert late.state_arrays()[name].tobytes() == array.tobytes(), name
    for _ in range(2):
        for first, second in zip(scattered(one, force), scattered(late, force), strict=True):
            assert first.tobytes() == second.tobytes()
        position[:, 1] += 0.9 * CELL * np.where(position[:, 1] < 7.0, 1.0, -1.0)
        assert one.check_positions() is None is late.check_positions()
        assert np.array_equal(one.slabs.left_slab, late.slabs.left_slab)
        one.sort_if_needed()
        late.sort_if_needed()
        assert np.array_equal(order_of(one), order_of(late))


def test_a_node_outside_the_grid_is_named():
    position, velocity, mass = nodes_at_random()
    coupling = coupled(position, velocity, mass)
    position[123, 2] = LOWER[2] - 0.01
    assert coupling.check_positions() == (LOST, 123)
