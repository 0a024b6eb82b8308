"""how the surface of a meshless solid responds to contact, beside the same by passes over all of its points."""

import numpy as np
import pytest
from small_cases import GAS, SOLID, box, simulation

from pellucid.grid.transfer import scatter_vectors


def block(functions):
    """A block of which an edge is held, and beside it what gives it a grid to touch on; its surface on that grid."""
    mesh = {"box": {"lower": (1, 1, 1), "upper": (4, 4, 3), "cells": (3, 3, 2)}}
    solid = {"name": "block", "field": "block", "kind": "meshless-solid", "mesh": mesh, "material": SOLID}
    other = box((2, 2, 4), (3, 3, 5), GAS, name="other", field="other")
    edge = {"body": "block", "where": {"box": {"lower": (0.9, 0.9, 2.9), "upper": (1.1, 9, 9)}}, "fix": ["x", "z"]}
    sim = simulation(solid, other, counts=(6, 6, 7), end=10.0, functions=functions, support=[edge])
    body = sim.bodies[0]
    body.arrays["position"] += 0.05 * np.sin(body.arrays["position"][:, [1, 2, 0]])
    body.update(0.0)
    body.begin(0.01)
    body.predict(0.01)
    return body


def by_all_points(body, at, trial):
    """Velocities of listed nodes with which it answers to the increments of all, shape (k, 3)."""
    skin, field = body.skin, body.coupling.velocity_field
    field.pressed = True
    increment = np.where(body.arrays["prescribed"] == 0, skin.gather(), 0.0)
    change = np.zeros_like(field.grid.nodes.velocity)
    scatter_vectors(skin.surface.n_slabs, skin.surface.mapped, skin._point_mass * (skin._values @ increment), change)
    nodes = field.grid.nodes
    return np.where(nodes.constrained[at] == 0, trial + change[at] / nodes.mass[at, None], trial)


@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_the_answer_of_few_nodes_is_that_of_the_whole_surface(functions):
    body, rng = block(functions), np.random.default_rng(0)
    field = body.coupling.velocity_field
    nodes = field.grid.nodes
    at = rng.permutation(np.flatnonzero(nodes.mass > 0.0))[:20]
    field.await_impulses([at[:12], at[5:]])
    at = field.awaiting
    assert (np.diff(at) > 0).all()
    assert len(at) == 20
    nodes.constrained[at[:4], 1] = 1
    trial = rng.normal(size=(20, 3))
    for _ in range(2):
        increment = rng.normal(size=(20, 3)) * (nodes.constrained[at] == 0)
        nodes.velocity_increment[at] = increment
        nodes.velocity[at] = trial + increment
        body.skin.respond()
        assert nodes.velocity[at] == pytest.approx(by_all_points(body, at, trial), abs=1e-13)
    assert (abs(nodes.velocity[at] - trial) > 0.01).sum() > 20


def test_a_new_step_asks_of_other_nodes():
    body = block("trilinear")
    field = body.coupling.velocity_field
    nodes = field.grid.nodes
    reached = np.flatnonzero(nodes.mass > 0.0)
    for at in (reached[:5], reached[-7:]):
        body.predict(0.01)
        field.await_impulses([at])
        nodes.velocity[at] = nodes.velocity_increment[at] = 1.0
        body.skin.respond()
        assert nodes.velocity[at] == pytest.approx(by_all_points(body, at, 0.0), abs=1e-13)
        nodes.velocity_increment[at] = 0.0
    field.await_impulses([])
    assert len(field.awaiting) == 0
