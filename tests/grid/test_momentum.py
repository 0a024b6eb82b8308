"""The nodes' equation of motion, against the same in numpy."""

import numpy as np
import pytest
from scenes import SLIP, box, case

from pellucid.conditions.walls import constrain_nodes
from pellucid.grid.lattice import Grid
from pellucid.grid.momentum import CHUNK, NodalMomentum

DT, SMALL = 0.25, 1e-3
GRAVITY = (0.5, 0.0, -2.0)


def nodes_at_random(counts, support=()):
    """A grid with masses, momenta and forces; some nodes are empty, some nearly so."""
    tables = case(box((0, 0, 0), counts), counts=counts, support=support)
    grid = Grid(tables.grid)
    walls = constrain_nodes(grid, tables.support)
    generator = np.random.default_rng(2)
    n = grid.n_nodes
    index, _ = grid.where()
    mass = np.zeros(n)
    mass[index] = generator.uniform(0.5, 2.0, len(index)) * generator.choice([0.0, 1e-6, 1.0], len(index))
    grid.nodes.mass[:] = mass
    grid.nodes.momentum[:] = mass[:, None] * generator.normal(size=(n, 3))
    grid.nodes.force[:] = generator.normal(size=(n, 3)) * (mass > 0.0)[:, None]
    return grid, walls


@pytest.mark.parametrize("counts", [(3, 3, 3), (20, 20, 20)])  # one chunk of nodes, several
def test_free_nodes_follow_newton(counts):
    grid, walls = nodes_at_random(counts)
    nodes = grid.nodes
    assert (grid.n_nodes > CHUNK) == (counts[0] > 3)
    work = NodalMomentum(nodes, walls, GRAVITY, SMALL, flip=1.0).advance(DT)
    full = nodes.mass > 0.0
    v = nodes.momentum[full] / nodes.mass[full, None]
    new = v + DT * (nodes.force[full] / nodes.mass[full, None] + np.array(GRAVITY))
    assert nodes.velocity_increment[full] == pytest.approx(new - v, rel=1e-12)  # differences of large accelerations
    heavy = nodes.mass[full] > SMALL
    assert nodes.velocity[full][heavy] == pytest.approx(new[heavy], rel=1e-14)
    assert not nodes.velocity[~full].any()
    assert not nodes.velocity_increment[~full].any()
    assert np.array_equal(nodes.velocity[full][heavy], nodes.strain_velocity[full][heavy])
    # the works leave out what light nodes do with velocities that no point has
    mean = 0.5 * (v + nodes.strain_velocity[full])
    assert work.mass == pytest.approx(nodes.mass.sum(), rel=1e-14)
    assert work.internal == pytest.approx(DT * np.sum(nodes.force[full] * mean), rel=1e-12)
    assert work.gravity == pytest.approx(DT * np.sum(nodes.mass[full, None] * mean * GRAVITY), rel=1e-12)
    assert work.support == 0.0
    # kinetic energy of the other nodes changes by exactly these works
    change = 0.5 * np.sum(nodes.mass[full, None][heavy] * (new**2 - v**2)[heavy])
    works = DT * np.sum((nodes.force[full] + nodes.mass[full, None] * GRAVITY)[heavy] * mean[heavy])
    assert change == pytest.approx(works, rel=1e-12)


def test_a_node_with_hardly_any_mass_strains_nothing_by_its_force():
    """A millionth of a point's mass under an ordinary force: f/m would be a million times too much in a gradient."""
    grid, walls = nodes_at_random((4, 4, 4))
    nodes = grid.nodes
    NodalMomentum(nodes, walls, (0.0, 0.0, 0.0), SMALL, flip=1.0).advance(DT)
    light = (nodes.mass > 0.0) & (nodes.mass < SMALL)
    assert light.any()
    assert nodes.strain_velocity[light] == pytest.approx(nodes.momentum[light] / nodes.mass[light, None])
    assert np.abs(nodes.velocity_increment[light]).max() > 1e3, (
        "the points still get the impulse, in proportion to their weight"
    )


def test_supports_hold_and_report_their_impulse():
    moving = {"where": "x-lower", "fix": ["x", "y"], "velocity": (0.5, -0.25, 9.0)}
    grid, walls = nodes_at_random((4, 4, 4), [*SLIP[2:], moving])
    nodes = grid.nodes
    work = NodalMomentum(nodes, walls, (0.0, 0.0, 0.0), SMALL, flip=1.0).advance(DT)
    full = nodes.mass > 0.0
    momentum = nodes.mass[full, None] * nodes.velocity_increment[full]
    # impulses of forces and supports make the whole change of momentum
    total = DT * nodes.force.sum(axis=0) + work.impulses.sum(axis=0)
    assert momentum.sum(axis=0) == pytest.approx(total, abs=1e-12 * np.abs(momentum).sum())
    for number, velocity in enumerate(walls.velocity):
        for axis in range(3):
            held = full & (nodes.constrained[:, axis] == number + 1)
            assert np.all(nodes.velocity[held, axis] == velocity[axis])
            assert np.all(nodes.strain_velocity[held, axis] == velocity[axis])
    assert work.support == pytest.approx(np.sum(work.impulses * walls.velocity), rel=1e-12)


def test_projection_is_momentum_over_mass_with_supports():
    grid, walls = nodes_at_random((4, 4, 4), [{"where": "z-upper", "fix": ["z"], "velocity": (0, 0, 2.0)}])
    nodes = grid.nodes
    NodalMomentum(nodes, walls, GRAVITY, SMALL, flip=1.0).project()
    full = nodes.mass > 0.0
    expected = np.zeros_like(nodes.momentum)
    expected[full] = nodes.momentum[full] / nodes.mass[full, None]
    held = nodes.constrained > 0
    assert nodes.strain_velocity[~held] == pytest.approx(expected[~held], rel=1e-15)
    assert np.all(nodes.strain_velocity[held] == 2.0)


def test_chunks_do_not_change_sums():
    """The works of a large grid are those of its nodes added in any order, to rounding."""
    grid, walls = nodes_at_random((30, 16, 16))
    work = NodalMomentum(grid.nodes, walls, GRAVITY, SMALL, flip=1.0).advance(DT)
    assert work.mass == pytest.approx(float(np.sum(grid.nodes.mass)), rel=1e-13)
