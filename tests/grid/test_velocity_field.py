"""Impulses on nodes beside the forces of a step: who does what work, and what they cannot move."""

import numpy as np
import pytest
from small_cases import SLIP, box, case

from pellucid.conditions.constrained_nodes import constrain_nodes
from pellucid.energy import FIRST_LOAD, GRAVITY, INTERNAL, SUPPORT
from pellucid.grid.actions import NodalActions
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_conditions import FULL_DRIVE_FRACTION
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.grid.velocity_field import VelocityField

DT, SMALL, PULL = 0.25, 1e-3, (0.5, 0.0, -2.0)
BRAKE = FIRST_LOAD + 1


def advanced(support=(), driven=False):
    """A velocity field with random masses, momenta, forces and loads after a step, and impulses; some nodes are empty."""
    tables = case(box((0, 0, 0), (4, 4, 4)), support=support)
    field = VelocityField("common", Grid(tables.grid))
    nodes, n = field.grid.nodes, field.grid.n_nodes
    generator = np.random.default_rng(5)
    walls = constrain_nodes(field.grid, tables.support)
    index, _ = field.grid.where()
    nodes.mass[index] = generator.uniform(0.5, 2.0, len(index)) * generator.choice([0.0, 1.0], len(index))
    full = nodes.mass > 0.0
    nodes.momentum[full], nodes.force[full] = nodes.mass[full, None] * generator.normal(size=(2, full.sum(), 3))
    actions = NodalActions(field, 1)
    actions.take_loads()
    if driven:
        actions.driven().mass[:] = nodes.mass[:, None] * generator.choice([0.0, FULL_DRIVE_FRACTION], (n, 1))
    external = actions.external()
    external.loads[0, full] = generator.normal(size=(full.sum(), 3))
    field.set_actions(walls, external, PULL, SMALL, flip=1.0)
    field.advance(DT)
    return field, full, generator.normal(size=(n, 3))


def test_the_works_of_all_are_the_change_of_kinetic_energy():
    """Each along the mean of the velocities before and after the step, so that what forces did changes with the impulses."""
    field, full, impulse = advanced()
    nodes = field.grid.nodes
    m, v = nodes.mass[full, None], nodes.momentum[full] / nodes.mass[full, None]
    free = nodes.velocity[full].copy()
    field.add_impulses(impulse, BRAKE, sign=-1.0)
    done = field.works(DT)
    new = free + impulse[full] / m
    assert nodes.velocity[full] == pytest.approx(new, rel=1e-14)
    assert nodes.strain_velocity[full] == pytest.approx(new, rel=1e-14)
    assert nodes.velocity_increment[full] == pytest.approx(new - v, rel=1e-12)
    mean = 0.5 * (v + new)
    assert nodes.mean_velocity[full] == pytest.approx(mean, rel=1e-12)
    assert done.works[BRAKE] == pytest.approx(-np.sum(impulse[full] * mean), rel=1e-12), "as heat"
    acting = {INTERNAL: nodes.force, GRAVITY: nodes.mass[:, None] * PULL, FIRST_LOAD: field.external.loads[0]}
    for column, force in acting.items():
        assert done.works[column] == pytest.approx(DT * np.sum(force[full] * mean), rel=1e-12)
    change = 0.5 * np.sum(m * (new**2 - v**2))
    assert done.works[:BRAKE].sum() - done.works[BRAKE] == pytest.approx(change, rel=1e-12)
    loads = DT * field.external.loads[0, full]
    assert done.impulse == pytest.approx((impulse[full] + loads).sum(axis=0), rel=1e-12)


def test_empty_and_constrained_nodes_take_nothing():
    field, full, impulse = advanced(SLIP)
    nodes = field.grid.nodes
    before = nodes.velocity.copy()
    field.add_impulses(impulse, BRAKE)
    held = nodes.constrained > 0
    assert np.array_equal(nodes.velocity[held], before[held])
    assert not nodes.velocity[~full].any()
    assert np.isfinite(nodes.velocity).all()
    taken = full[:, None] & ~held
    assert nodes.velocity[taken] == pytest.approx(
        (before + impulse / np.where(full, nodes.mass, 1.0)[:, None])[taken], rel=1e-12
    )
    done = field.works(DT)
    loads = DT * field.external.loads[0]
    assert done.impulse == pytest.approx((np.where(taken, impulse, 0.0) + loads).sum(axis=0), rel=1e-12)
    assert done.works[SUPPORT] == 0.0


def test_nodes_that_driven_points_lead_take_nothing():
    field, full, impulse = advanced(driven=True)
    nodes, led = field.grid.nodes, field.external.driven_mass[:, 0] > 0.0
    assert (led & full).any()
    assert (full & ~led).any()
    before = nodes.velocity.copy()
    field.add_impulses(impulse, BRAKE)
    assert np.array_equal((nodes.velocity != before).any(axis=1), full & ~led)


def test_a_light_node_is_moved_and_strains_nothing():
    field, full, impulse = advanced()
    nodes, light = field.grid.nodes, int(np.flatnonzero(full)[0])
    nodes.strain_velocity[light] += 1.0  # as the momentum equation leaves it where forces must not strain points
    before, strained = nodes.velocity[light].copy(), nodes.strain_velocity[light].copy()
    field.add_impulses(impulse, BRAKE)
    assert nodes.velocity[light] == pytest.approx(before + impulse[light] / nodes.mass[light], rel=1e-14)
    assert np.array_equal(nodes.strain_velocity[light], strained)


def test_a_body_with_its_own_nodes_is_not_moved_by_the_grid():
    field = OwnNodesField("own", Grid(case(box((0, 0, 0), (4, 4, 4))).grid))
    with pytest.raises(ValueError, match="the velocity field own does not move its body"):
        field.add_impulses(np.zeros((field.grid.n_nodes, 3)), BRAKE)


def test_forces_that_nothing_asked_for_are_refused():
    tables = case(box((0, 0, 0), (4, 4, 4)))
    field = VelocityField("common", Grid(tables.grid))
    field.set_actions(constrain_nodes(field.grid, ()), NodalActions(field, 1).external(), PULL, SMALL, flip=1.0)
    with pytest.raises(ValueError, match="no condition has requested external forces in the velocity field common"):
        field.load_row(0)
