"""The nodes that a body with its own nodes reaches: what they take, and that passes over them alone are those over all."""

import numpy as np
import pytest
from small_cases import SLIP, box, case

from pellucid.approximants import grid_functions
from pellucid.bodies.own_nodes.grid_transfer import GridCoupling
from pellucid.conditions.constrained_nodes import constrain_nodes
from pellucid.grid.actions import NodalActions
from pellucid.grid.lattice import Grid
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.grid.velocity_field import VelocityField

COUNTS, N, DT = (12, 6, 6), 300, 0.1


def fields(driven):
    """Two velocity fields, one that moves no points and one that does, with a support; `driven`: with more that acts."""
    tables = case(box((0, 0, 0), COUNTS), counts=COUNTS, support=SLIP)
    made = []
    for kind in (OwnNodesField, VelocityField):
        field = kind("own", Grid(tables.grid))
        actions, generator = NodalActions(field, 0), np.random.default_rng(5)
        if driven:
            shape = (field.grid.n_nodes, 3)
            actions.absorption()[:] = generator.uniform(0.0, 2.0, shape)
            actions.driven().mass[:] = generator.uniform(0.0, 0.1, shape) * generator.choice([0.0, 1.0], shape)
            actions.driven().momentum[:] = actions.driven().mass * generator.normal(size=shape)
        walls = constrain_nodes(field.grid, tables.support)
        field.set_actions(walls, actions.external(), (0.0, 0.0, 0.0), small_mass=0.0, flip=1.0)
        made.append(field)
    return made


def coupling_of(field):
    generator = np.random.default_rng(6)
    position = (0.2 + 0.6 * generator.random((N, 3))) * COUNTS
    functions = grid_functions("trilinear", (2, 2, 2), field.grid.thin)
    return GridCoupling(field, functions, position, generator.normal(size=(N, 3)), generator.uniform(0.5, 2.0, N)), position


def test_what_was_given_before_is_gone_wherever_the_points_went():
    field, _ = fields(driven=False)
    coupling, position = coupling_of(field)
    nodes, force = field.grid.nodes, np.random.default_rng(7).normal(size=(N, 3))
    for _ in range(2):
        coupling.scatter(force)
        full = np.flatnonzero(nodes.mass)
        assert np.isin(full, field.reached).all()
        assert np.all(np.diff(field.reached) > 0)
        points = coupling.mapped.points
        assert nodes.mass.sum() == pytest.approx(points.mass.sum(), rel=1e-12)
        assert nodes.momentum.sum(axis=0) == pytest.approx(points.mass @ points.velocity, abs=1e-12 * points.mass.sum())
        assert nodes.force.sum(axis=0) == pytest.approx(force.sum(axis=0), abs=1e-12 * np.abs(force).sum())
        assert not np.delete(nodes.forces.reshape(-1, 4), full, axis=0).any()
        position[:, 0] += 0.5
        coupling.sort()
    coupling.scatter()
    assert not nodes.force.any()


@pytest.mark.parametrize("driven", [False, True])
def test_they_move_as_those_of_a_whole_grid(driven):
    own, whole = fields(driven)
    coupling, _ = coupling_of(own)
    coupling.scatter(np.random.default_rng(7).normal(size=(N, 3)))
    for name in ("inertia", "forces"):
        getattr(whole.grid.nodes, name)[:] = getattr(own.grid.nodes, name)
    for field in (own, whole):
        field.grid.nodes.velocity_increment[:] = 7.0
        field.advance(DT)
    full = whole.grid.nodes.mass > 0.0
    assert own.grid.nodes.velocity[full] == pytest.approx(whole.grid.nodes.velocity[full], rel=1e-13, abs=1e-13)
    assert not own.grid.nodes.velocity_increment[own.reached].any()
    for field in (own, whole):
        field.project()
    assert own.grid.nodes.strain_velocity[full] == pytest.approx(whole.grid.nodes.strain_velocity[full], rel=1e-13, abs=1e-13)
