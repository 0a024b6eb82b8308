"""Contact points of membranes: places without the hourglass modes of quadrilaterals, and forces by the same shares."""

import numpy as np
import pytest
from small_cases import simulation

SKIN = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
ELASTIC = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e6, "poisson_ratio": 0.3}


def sheet_on_a_wall(elements="quads", n=9):
    rectangle = {"corner": (1, 1, 1), "first_edge": (8, 0, 0), "second_edge": (1, 8, 0), "points": (n, n)}
    sheet = {
        "name": "sheet",
        "field": "sheet",
        "kind": "membrane-elements",
        "elements": elements,
        "surface": {"rectangle": rectangle},
        "thickness": 0.1,
        "material": SKIN,
    }
    sim = simulation(sheet, counts=(12, 12, 4), wall=[{"point": (0, 0, 0.5), "normal": (0, 0, 1)}], end=1.0)
    body = sim.bodies[0]
    return body, body.contact_surface


def of_quads(body, values):
    """Σ ±values over the corners of each quadrilateral."""
    return np.einsum("i,qi->q", np.array([1.0, -1.0, 1.0, -1.0]), values[body.surface.cells.quadrilaterals])


def test_linear_fields_are_where_the_nodes_are():
    body, surface = sheet_on_a_wall()
    x = body.arrays["position"]
    x[:, 2] += 0.1 * x[:, 0] - 0.3 * x[:, 1]
    surface.begin()
    assert surface.place == pytest.approx(x, abs=1e-12)


def test_hourglass_patterns_move_no_point():
    body, surface = sheet_on_a_wall()
    pattern = np.where(np.add(*np.divmod(np.arange(81), 9)) % 2 == 0, 1.0, -1.0)
    assert np.abs(of_quads(body, pattern)) == pytest.approx(np.full(64, 4.0))
    body.arrays["velocity"][:, 2] = pattern
    surface.begin()
    assert surface.velocity == pytest.approx(np.zeros((81, 3)), abs=1e-12)


def test_a_force_on_a_point_hardly_excites_hourglass_modes():
    """The forces are those of the places: they keep force and torque and do the work that they do on the points."""
    body, surface = sheet_on_a_wall()
    loads, rng = body.motion.loads, np.random.default_rng(3)
    force = np.zeros((81, 3))
    force[40, 2] = 1.0
    loads.fill(0.0)
    surface.add_forces(force)
    given, x = loads.sum(axis=0), body.arrays["position"]
    assert given.sum(axis=0) == pytest.approx([0.0, 0.0, 1.0], abs=1e-12)
    assert np.cross(x, given).sum(axis=0) == pytest.approx(np.cross(x[40], force[40]), abs=1e-11)
    assert np.sum(of_quads(body, given[:, 2]) ** 2) < 0.3 * np.sum(of_quads(body, force[:, 2]) ** 2)
    body.arrays["velocity"][...] = rng.standard_normal((81, 3))
    surface.begin()
    assert np.sum(given * body.arrays["velocity"]) == pytest.approx(np.sum(force * surface.velocity), rel=1e-12)


def test_points_of_triangles_are_the_nodes():
    body, surface = sheet_on_a_wall("triangles")
    body.arrays["position"][:, 2] += np.random.default_rng(1).standard_normal(81)
    surface.begin()
    assert np.array_equal(surface.place, body.arrays["position"])


def test_a_solid_lets_contact_know_how_its_points_move():
    """Free nodes go by their forces, held ones keep their velocity and answer to nothing."""
    mesh = {"box": {"lower": (1, 1, 0), "upper": (3, 3, 2), "cells": (2, 2, 2)}}
    block = {"name": "block", "field": "block", "kind": "meshless-solid", "mesh": mesh, "material": ELASTIC}
    wall = [{"point": (0.5, 0, 0), "normal": (1, 0, 0)}]
    sim = simulation(block, counts=(4, 4, 4), wall=wall, support=[{"where": "z-lower", "fix": "normal"}], end=1.0)
    body = sim.bodies[0]
    response, motion, dt = body.contact_surface.response, body.motion, 0.01
    body.motion.internal[...] = np.random.default_rng(2).standard_normal(motion.internal.shape)
    free = np.where(motion.free, dt * motion.internal / body.arrays["mass"][:, None], 0.0)
    assert not motion.free.all()
    assert response.velocities(dt, None) == pytest.approx(response.shares @ free, abs=1e-15)
    push = np.random.default_rng(4).standard_normal(body.contact_surface.place.shape)
    change = response.answers(dt) * (response.shares.T @ push)
    assert np.all(change[~motion.free] == 0.0)
    assert response.velocities(dt, push) == pytest.approx(response.shares @ (free + change), abs=1e-12)
