"""The nodes' equation of motion, against the same in numpy."""

import numpy as np
import pytest
from small_cases import SLIP, box, case

from pellucid import energy
from pellucid.conditions.constrained_nodes import constrain_nodes
from pellucid.grid.actions import NodalActions
from pellucid.grid.chunks import CHUNK
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_conditions import ExternalAction
from pellucid.grid.nodal_fields import allocate
from pellucid.grid.nodal_momentum import NodalMomentum
from pellucid.grid.velocity_field import VelocityField

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


def advanced(nodes, walls, gravity, external=None):
    """The works of a step of these nodes."""
    momentum = momentum_of(nodes, walls, gravity, external)
    momentum.advance(DT)
    return momentum.works(DT)


def momentum_of(nodes, walls, gravity, external=None):
    """Of these nodes, on which nothing else acts where `external` is left out."""
    free = allocate(ExternalAction, 0)
    return NodalMomentum(nodes, np.array([0, len(nodes.mass)]), walls, gravity, SMALL, flip=1.0, external=external or free)


@pytest.mark.parametrize("counts", [(3, 3, 3), (20, 20, 20)])  # one chunk of nodes, several
def test_free_nodes_follow_newton(counts):
    grid, walls = nodes_at_random(counts)
    nodes = grid.nodes
    assert (grid.n_nodes > CHUNK) == (counts[0] > 3)
    full = nodes.mass > 0.0
    v = nodes.momentum[full] / nodes.mass[full, None]
    work = advanced(nodes, walls, GRAVITY)
    assert not nodes.momentum.any(), "it is mapped again"
    new = v + DT * (nodes.force[full] / nodes.mass[full, None] + np.array(GRAVITY))
    assert nodes.velocity_increment[full] == pytest.approx(new - v, rel=1e-12)  # differences of large accelerations
    heavy = nodes.mass[full] > SMALL
    assert nodes.velocity[full][heavy] == pytest.approx(new[heavy], rel=1e-14)
    assert not nodes.velocity[~full].any()
    assert not nodes.velocity_increment[~full].any()
    assert np.array_equal(nodes.velocity[full][heavy], nodes.strain_velocity[full][heavy])
    # the works leave out what light nodes do with velocities that no point has
    mean = np.where(heavy[:, None], 0.5 * (v + new), v)
    assert nodes.mean_velocity[full] == pytest.approx(mean, rel=1e-12)
    squares = 0.5 * np.sum(np.where(heavy[:, None], new - v, DT * np.array(GRAVITY)) ** 2, axis=1)
    assert nodes.increment_energy[full] == pytest.approx(squares, rel=1e-12)
    assert work.gravity_mass == pytest.approx(nodes.mass.sum(), rel=1e-14)
    assert work.works[energy.INTERNAL] == pytest.approx(DT * np.sum(nodes.force[full] * mean), rel=1e-12)
    falling = np.where(heavy[:, None], mean, v + 0.5 * DT * np.array(GRAVITY))
    assert work.works[energy.GRAVITY] == pytest.approx(DT * np.sum(nodes.mass[full, None] * falling * GRAVITY), rel=1e-12)
    assert work.works[energy.SUPPORT] == 0.0
    # kinetic energy of the other nodes changes by exactly these works
    change = 0.5 * np.sum(nodes.mass[full, None][heavy] * (new**2 - v**2)[heavy])
    works = DT * np.sum((nodes.force[full] + nodes.mass[full, None] * GRAVITY)[heavy] * mean[heavy])
    assert change == pytest.approx(works, rel=1e-12)


@pytest.mark.parametrize("impulses", [False, True])
def test_works_counted_with_the_advance_are_those_counted_after_it(impulses):
    """With impulses on some nodes, after these were advanced and after momentum was mapped again, if they await any."""
    found = []
    for counted in (False, True):
        grid, walls = nodes_at_random((20, 20, 20), SLIP)
        nodes, momentum, generator = grid.nodes, momentum_of(grid.nodes, walls, GRAVITY), np.random.default_rng(3)
        moved = generator.permutation(np.flatnonzero(nodes.mass > SMALL))[: 2 * CHUNK]
        mapped = nodes.momentum.copy()
        for first in (0, CHUNK):  # what the first step leaves must not count in the second, nor nodes await impulses still
            moved = moved[first:]
            if impulses and counted:
                momentum.await_impulses([moved[:CHUNK], moved[CHUNK // 2 :]])
            nodes.momentum[:] = mapped
            momentum.advance(DT, counted)
            change = generator.normal(size=(len(moved), 3)) if impulses else 0.0
            for velocity in (nodes.velocity, nodes.velocity_increment, nodes.strain_velocity):
                velocity[moved] += change
            work = momentum.works(DT)
            nodes.momentum[:] = 0.5 * mapped
            momentum.project(DT, counted)
            nodes.strain_velocity[moved] += change
            lag = np.array([momentum.strain_lag_work(DT)])
        found.append((work.works, work.reactions, nodes.mean_velocity.copy(), nodes.increment_energy.copy(), lag))
    for after, at_once in zip(*found, strict=True):
        assert np.abs(after).max() > 0.0
        assert at_once == pytest.approx(after, rel=1e-12, abs=1e-12 * np.abs(after).max())


def test_rows_of_nodes_that_lost_their_mass_are_zero():
    grid, walls = nodes_at_random((20, 20, 20), SLIP)
    nodes, momentum = grid.nodes, momentum_of(grid.nodes, walls, GRAVITY)
    momentum.advance(DT, counted=True)
    momentum.project(DT, counted=True)
    lost = np.flatnonzero(nodes.mass)[::2]
    nodes.inertia.reshape(-1, 4)[lost] = 0.0
    momentum.advance(DT, counted=True)
    for rows in (nodes.velocities, nodes.increments, nodes.strain_velocities, nodes.mean_velocities):
        assert not rows.reshape(-1, 4)[lost].any()


def test_a_node_with_hardly_any_mass_strains_nothing_by_its_force():
    """A millionth of a point's mass under an ordinary force: f/m would be a million times too much in a gradient."""
    grid, walls = nodes_at_random((4, 4, 4))
    nodes = grid.nodes
    light = (nodes.mass > 0.0) & (nodes.mass < SMALL)
    assert light.any()
    mapped = nodes.momentum[light] / nodes.mass[light, None]
    advanced(nodes, walls, (0.0, 0.0, 0.0))
    assert nodes.strain_velocity[light] == pytest.approx(mapped)
    assert np.abs(nodes.velocity_increment[light]).max() > 1e3, (
        "the points still get the impulse, in proportion to their weight"
    )


def test_supports_hold_and_report_their_impulse():
    moving = {"where": "x-lower", "fix": ["x", "y"], "velocity": (0.5, -0.25, 9.0)}
    grid, walls = nodes_at_random((4, 4, 4), [*SLIP[2:], moving])
    nodes = grid.nodes
    work = advanced(nodes, walls, (0.0, 0.0, 0.0))
    full = nodes.mass > 0.0
    momentum = nodes.mass[full, None] * nodes.velocity_increment[full]
    # impulses of forces and supports make the whole change of momentum
    total = DT * nodes.force.sum(axis=0) + work.reactions.sum(axis=0)
    assert momentum.sum(axis=0) == pytest.approx(total, abs=1e-12 * np.abs(momentum).sum())
    for number, velocity in enumerate(walls.velocity):
        for axis in range(3):
            held = full & (nodes.constrained[:, axis] == number + 1)
            assert np.all(nodes.velocity[held, axis] == velocity[axis])
            assert np.all(nodes.strain_velocity[held, axis] == velocity[axis])
    assert work.works[energy.SUPPORT] == pytest.approx(np.sum(work.reactions * walls.velocity), rel=1e-12)


def test_projection_is_momentum_over_mass_with_supports():
    grid, walls = nodes_at_random((4, 4, 4), [{"where": "z-upper", "fix": ["z"], "velocity": (0, 0, 2.0)}])
    nodes = grid.nodes
    momentum_of(nodes, walls, GRAVITY).project()
    full = nodes.mass > 0.0
    expected = np.zeros_like(nodes.momentum)
    expected[full] = nodes.momentum[full] / nodes.mass[full, None]
    held = nodes.constrained > 0
    assert nodes.strain_velocity[~held] == pytest.approx(expected[~held], rel=1e-15)
    assert np.all(nodes.strain_velocity[held & full[:, None]] == 2.0)


def test_chunks_do_not_change_sums():
    """The works of a large grid are those of its nodes added in any order, to rounding."""
    grid, walls = nodes_at_random((30, 16, 16))
    work = advanced(grid.nodes, walls, GRAVITY)
    assert work.gravity_mass == pytest.approx(float(np.sum(grid.nodes.mass)), rel=1e-13)


def test_loads_push_absorbing_faces_brake_and_each_has_its_column():
    """Two channels of loads, against the same in numpy; absorption by the mean velocity over the step, on both sides of it."""
    grid, walls = nodes_at_random((4, 4, 4))
    nodes, generator = grid.nodes, np.random.default_rng(7)
    nodes.mass[nodes.mass < 0.1] = 0.0  # without light nodes, whose works are those of other velocities
    full = nodes.mass > 0.0
    nodes.momentum[~full] = nodes.force[~full] = 0.0
    actions = NodalActions(VelocityField("common", grid), 2)
    actions.take_loads()
    actions.absorption()
    external = actions.external()
    external.loads[:, full] = generator.normal(size=(2, full.sum(), 3))
    external.absorption[full] = generator.uniform(0.0, 3.0, (full.sum(), 3))
    m, first, second = nodes.mass[full, None], *external.loads[:, full]
    v, half = nodes.momentum[full] / m, 0.5 * DT * external.absorption[full]
    work = advanced(nodes, walls, GRAVITY, external)
    pushed = v + DT * ((nodes.force[full] + first + second) / m + np.array(GRAVITY))
    new = (pushed - half * v) / (1.0 + half)
    assert nodes.velocity[full] == pytest.approx(new, rel=1e-12)
    mean, taken = 0.5 * (v + new), m * (new - pushed)
    works = work.works
    assert works[energy.FIRST_LOAD :] == pytest.approx([DT * np.sum(load * mean) for load in (first, second)], rel=1e-12)
    assert works[energy.ABSORBED] == pytest.approx(-np.sum(taken * mean), rel=1e-12)
    assert works[energy.ABSORBED] > 0.0
    change = 0.5 * np.sum(m * (new**2 - v**2))
    others = works[energy.INTERNAL] + works[energy.GRAVITY] + works[energy.FIRST_LOAD :].sum()
    assert change == pytest.approx(others - works[energy.ABSORBED], rel=1e-12)
    impulse = DT * (first + second).sum(axis=0) + taken.sum(axis=0)
    assert work.impulse == pytest.approx(impulse, abs=1e-12 * np.abs(taken).sum())
    assert not work.reactions.any()
