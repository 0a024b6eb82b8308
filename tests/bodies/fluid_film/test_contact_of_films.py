"""Films that share their velocity field with the fluid inside touch solids by their surface."""

import numpy as np
import pytest
from small_cases import RATE_SOLID, advance, box, simulation

from pellucid.bodies.own_nodes.contact_surface import PointsOfNodes
from pellucid.contact.pairs import ContactPairs
from pellucid.contact.surface_pairs import SurfacePairs

LIPID = {"kind": "lipid-film", "density": 0.05, "viscosity": 0.1, "stiffness": 400.0}
EOS = {"kind": "tait", "sound_speed": 60.0, "carries_tension": True}
LIQUID = {"kind": "fluid", "density": 0.2, "viscosity": 1.0, "eos": EOS}
QUIET = {"warn": 1e3, "stop": 1e4}
TOUCH = [{"name": "touch", "between": ["film", "high"]}]


def vesicle(centre, radius, stretched=1.02, nodes=48, velocity=(0.0, 0.0, 0.0)):
    """A circular film that is stretched, and the liquid inside."""
    shape = {"ellipse": {"radius": radius, "centre": (*centre, 0.0), "nodes": nodes}}
    film = {"kind": "fluid-film", "name": "film", "shape": shape, "material": LIPID, "density": 0.05 / stretched}
    inner = {"cylinder": {"centre": (*centre, 0.0), "radius": 0.985 * radius}}
    liquid = {"name": "liquid", "shape": inner, "points_per_cell": (2, 2, 1), "material": LIQUID}
    return film | {"velocity": velocity}, liquid | {"velocity": velocity}


def on_a_plate(centre=(1.6, 1.76), velocity=(1.0, 0.0, 0.0), **more):
    plate = box((0.25, 0.25, 0), (6.75, 0.75, 0), RATE_SOLID, (2, 2, 1), name="plate", field="plate")
    how = {"counts": (28, 14, 0), "cell": 0.25, "functions": "quadratic-bspline", "end": 10.0, "gravity": (0, -1.5, 0)}
    held = [{"name": "hold", "body": "plate", "hold": ["x", "y"]}]
    return simulation(*vesicle(centre, 1.0, 1.05, 40, velocity), plate, motion=held, energy=QUIET, **how | more)


def test_a_vesicle_glides_on_a_plate_and_keeps_its_velocity():
    """A plate without friction gives no force along it; on the nodes of the grid the same vesicle is slowed down."""
    sim = on_a_plate()
    assert not len(sim.parts.only(ContactPairs))
    (pair,) = sim.parts.only(SurfacePairs)._pairs
    assert pair.between == ("body film", "body plate")
    advance(sim, 500)
    film, liquid, _ = sim.bodies
    momentum = film.totals.momentum + liquid.totals.momentum
    assert momentum[0] == pytest.approx(film.mass + liquid.mass, rel=1e-9)
    assert film.places()[:, 1].min() - 0.75 == pytest.approx(0.0, abs=0.02 * 0.25)
    energy = sim.parts.only(SurfacePairs).energy
    assert abs(energy.unexplained) < 0.005 * 0.5 * (film.mass + liquid.mass)


def test_liquid_outside_keeps_contact_on_the_nodes():
    sea = box((0.25, 0.75, 0), (6.75, 3.0, 0), LIQUID, (2, 2, 1), name="sea", outside=["liquid"])
    (film, liquid), held = vesicle((1.6, 1.76), 0.9), [{"name": "hold", "body": "plate", "hold": ["x", "y"]}]
    plate = box((0.25, 0.25, 0), (6.75, 0.75, 0), RATE_SOLID, (2, 2, 1), name="plate", field="plate")
    how = {"counts": (28, 14, 0), "cell": 0.25, "functions": "quadratic-bspline", "end": 10.0}
    sim = simulation(film, liquid, sea, plate, motion=held, **how)
    assert len(sim.parts.only(ContactPairs)) == 1
    assert not len(sim.parts.only(SurfacePairs))
    (line,) = sim.parts.only(ContactPairs).reasons
    assert "the velocity field of film also contains the fluid outside of it (liquid, sea)" in line


def test_points_of_a_film_in_space_lie_on_it():
    """Nodes of a Loop surface lie beside it: on a sphere of radius R and edges h by about h²/6R."""
    radius = 0.5
    shape = {"surface": {"sphere": {"centre": (1.0, 1.0, 1.2), "radius": radius, "divisions": 5}}}
    film = {"kind": "fluid-film", "name": "film", "shape": shape, "material": LIPID}
    drop = {"name": "drop", "shape": {"sphere": {"centre": (1.0, 1.0, 1.2), "radius": 0.45}}, "material": LIQUID}
    plate = box((0.25, 0.25, 0.25), (1.75, 1.75, 0.6), RATE_SOLID, None, name="plate", field="plate")
    held = [{"name": "hold", "body": "plate", "hold": ["x", "y", "z"]}]
    sim = simulation(film, drop, plate, counts=(8, 8, 8), cell=0.25, motion=held)
    ((surface,),) = [[s for s in pair.surfaces if isinstance(s, PointsOfNodes)] for pair in sim.parts.only(SurfacePairs)._pairs]
    body = sim.bodies[0]
    on_film = np.linalg.norm(surface.place - (1.0, 1.0, 1.2), axis=1)
    nodes = np.linalg.norm(body.places() - (1.0, 1.0, 1.2), axis=1)
    assert np.abs(on_film - radius).mean() < 0.002 * radius
    assert np.abs(nodes - radius).mean() > 5.0 * np.abs(on_film - radius).mean()
    force = np.random.default_rng(1).uniform(-1.0, 1.0, surface.place.shape)
    before = body.velocity_field.load_row(0).sum(axis=0)
    surface.add_forces(force)
    added = body.velocity_field.load_row(0).sum(axis=0) - before
    assert added == pytest.approx(force.sum(axis=0), abs=1e-12 * np.abs(force).sum())


def test_contact_of_a_film_resumes_with_the_same_bits():
    one, late = on_a_plate(), on_a_plate()
    advance(one, 60)
    late.restore({name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers())
    for sim in (one, late):
        advance(sim, 10)
    for name, array in one.state_arrays().items():
        assert late.state_arrays()[name].tobytes() == array.tobytes(), name


@pytest.mark.slow
def test_a_vesicle_between_two_plates_presses_with_its_pressure_over_the_area_of_contact():
    """A vesicle without bending is two half circles of radius R = H/2 and two straight parts of length w between plates that
    are H apart; its pressure is T/R, so that the force on a plate is T w/R."""
    film, liquid = vesicle((2.5, 2.5), 1.25)
    low = box((0.5, 0.5, 0), (4.5, 1.25, 0), RATE_SOLID, (2, 2, 1), name="low", field="low", rigid=True)
    high = box((0.5, 3.75, 0), (4.5, 4.5, 0), RATE_SOLID, (2, 2, 1), name="high", field="high", rigid=True)
    motion = [
        {"name": name, "body": name, "hold": ["x"], "hold_rotation": ["z"], "displacement": {"y": ramp}}
        for name, ramp in (
            ("low", {"kind": "ramp", "distance": 0.15, "duration": 0.4}),
            ("high", {"kind": "ramp", "distance": -0.15, "duration": 0.4}),
        )
    ]
    how = {"counts": (20, 20, 0), "cell": 0.25, "functions": "quadratic-bspline", "end": 3.0, "energy": QUIET}
    sim = simulation(film, liquid, low, high, motion=motion, contact=TOUCH, **how)
    pushed = []
    while not sim.clock.finished(None):
        sim.step()
        pushed.append((sim.time, sim.budget.reactions()["touch"][1]))
    (start, before), (end, after) = pushed[2 * len(pushed) // 3], pushed[-1]
    body, radius = sim.bodies[0], 0.5 * (2.5 - 0.3)
    x, y = body.places()[:, :2].T
    area = 0.5 * abs(float(np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))))
    width = (area - np.pi * radius**2) / (2.0 * radius)
    tension = body.frame()["tension"].mean()
    force = (before - after) / (end - start) / sim.case.grid.slice_thickness()
    assert np.ptp(body.places()[:, 1]) == pytest.approx(2.0 * radius, rel=1e-3)
    assert force == pytest.approx(tension / radius * width, rel=0.03)
