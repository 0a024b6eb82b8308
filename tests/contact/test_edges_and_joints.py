"""What glides over a joint or an edge of what bears it, or out of the grid, is not held there."""

import numpy as np
import pytest
from small_cases import RATE_SOLID, box, simulation

from pellucid.contact import proximity
from pellucid.contact.images import NO_IMAGES
from pellucid.contact.proximity import GAP, SHARE, Asking, Candidates, Meeting, Neighbourhood, Points, make_room

STIFF = RATE_SOLID | {"young_modulus": 4e6}
SIZE = {"counts": (40, 20, 1), "cell": 0.05, "functions": "gimp", "thickness": 1.0, "gravity": (0, -9.81, 0)}


def plate(name, left, right):
    return box((left, 0, 0), (right, 0.2, 0), RATE_SOLID, None, name=name, field=name)


def held(*names):
    return [{"name": f"hold-{name}", "body": name, "hold": ["x", "y", "z"]} for name in names]


def slider(velocity, left):
    return box((left, 0.2, 0), (left + 0.4, 0.4, 0), STIFF, None, name="slider", field="slider", velocity=(velocity, 0, 0))


def test_a_block_glides_over_a_joint():
    """Of two plates that lie flush. Held there it lost a hundredth of its velocity."""
    sim = simulation(plate("one", 0, 1), plate("two", 1, 2), slider(2.0, 0.5), motion=held("one", "two"), end=0.3, **SIZE)
    while sim.time < 0.299:
        sim.step()
    body = sim.bodies[2]
    assert body.totals.momentum[0] / body.mass == pytest.approx(2.0, abs=2e-3)
    assert abs(sim.budget.sums["contact_work"]) < 5e-3 * sim.kinetic_energy()


def test_a_block_slides_out_of_the_grid_over_the_end_of_its_plate():
    """With friction: what leaves takes along what is left of its energy, as over a floor without an end."""
    touch = [{"between": ["slider", "one"], "kind": "coulomb", "friction": 0.2}]
    outflow = [{"where": ["x-upper"], "body": ["slider"]}]
    sim = simulation(plate("one", 0, 2), slider(4.0, 1.3), motion=held("one"), contact=touch, outflow=outflow, end=0.3, **SIZE)
    fastest = 0.0
    while sim.time < 0.299:
        sim.step()
        body = sim.bodies[1]
        there = body.arrays["mass"] > 0.0
        if there.any():
            fastest = max(fastest, float(np.abs(body.arrays["velocity"][there]).max()))
    assert fastest < 4.3
    assert sim.n_steps > 100
    # every point loses µ g times its way to the face: 0.7 m of the middle
    start, lost = 0.5 * 80.0 * 4.0**2, 80.0 * 0.2 * 9.81 * 0.5
    assert sim.budget.sums["outflow_energy"] == pytest.approx(start - lost, rel=0.01)


def test_a_lone_point_tells_no_slope():
    """Its place is the foot of all that lie beside it."""
    lone = Points(np.array([[0.3, 0.0, 0.5]]), np.array([[0.0, 1.0, 0.0]]), np.array([2.0]), np.array([1.0]))
    places, normals = np.array([[0.1, -0.02, 0.5], [0.55, -0.01, 0.5]]), np.tile([0.0, -1.0, 0.0], (2, 1))
    both = Candidates(np.arange(2), np.array([0, 1, 2]), np.zeros(2, np.int64))
    about, found = Neighbourhood(Asking(places, normals), lone, Meeting((False, False), 1.0, 1, 1.0)), make_room(2, 2)
    proximity.find_beside(1, about, both, 0.0, found)
    assert found.beside[:, GAP] == pytest.approx([-0.02, -0.01])
    assert (found.beside[:, SHARE] > 0.0).all()
    of_one, of_other = (np.ones(2), np.ones(2), np.zeros((2, 3))), np.ones((1, 3))
    assert proximity.measure_depths(about, both, found, *of_one, of_other, NO_IMAGES, 0.0, 0.0, True, False) == 2
    assert found.share == pytest.approx([1.0, 1.0], abs=1e-9)
    assert found.depth == pytest.approx([0.02, 0.01], abs=1e-9)
    assert found.relative == pytest.approx(-np.ones((2, 3)), abs=1e-9)
