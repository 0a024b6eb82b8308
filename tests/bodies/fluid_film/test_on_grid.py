"""Films that share their velocity field with fluid."""

import numpy as np
import pytest
from pydantic import ValidationError
from small_cases import SOLID, advance, box, simulation

from pellucid.bodies.fluid_film.body import FluidFilm
from pellucid.bodies.fluid_film.on_grid import FilmOnGrid
from pellucid.errors import CaseError
from pellucid.geometry.meshes.enclosure import ellipse_of

LIPID = {"kind": "lipid-film", "density": 0.05, "viscosity": 0.1, "stiffness": 400.0, "bending_rigidity": 0.2}
EOS = {"kind": "tait", "sound_speed": 60.0, "carries_tension": True}
LIQUID = {
    "kind": "fluid",
    "density": 0.2,
    "viscosity": 1.0,
    "eos": {"kind": "tait", "sound_speed": 60.0, "carries_tension": True},
}
BALL = {"surface": {"sphere": {"centre": (2.5, 2.5, 0.0), "radius": 1.0, "divisions": 4}}}
ELLIPSE = {"ellipse": {"radius": 1.25, "radius_y": 0.8, "centre": (2.5, 2.5, 0.0), "nodes": 48}}


def film(shape=ELLIPSE, material=LIPID, **more):
    return {"kind": "fluid-film", "name": "film", "shape": shape, "material": material} | more


def in_liquid(of=None, velocity=(0.0, 0.0, 0.0), **more):
    """A film in a square of liquid with nothing outside."""
    liquid = box((0.5, 0.5, 0.0), (4.5, 4.5, 0.0), LIQUID, (2, 2, 1), name="liquid", velocity=velocity)
    grid = {"counts": (20, 20, 0), "cell": 0.25, "functions": "quadratic-bspline", "end": 10.0} | more
    return simulation(of or film(), liquid, **grid)


def test_the_kind_of_body_is_chosen_by_who_shares_the_field():
    assert isinstance(in_liquid().bodies[0], FilmOnGrid)
    alone = simulation(film(drag={"normal": 1.0, "tangential": 1.0}), counts=(20, 20, 0), cell=0.25)
    assert isinstance(alone.bodies[0], FluidFilm)


@pytest.mark.parametrize("nodes", ["even", "material"])
def test_a_film_that_travels_with_the_fluid_keeps_its_shape(nodes):
    """Without tension and bending nothing acts: all go on at the velocity of the start."""
    velocity, soft = (0.3, -0.2, 0.0), LIPID | {"bending_rigidity": 0.0}
    sim = in_liquid(film(material=soft, velocity=velocity, nodes=nodes), velocity)
    body = sim.bodies[0]
    begun, tension = body.places(), body.frame()["tension"]
    advance(sim, 100)
    assert body.places() - begun == pytest.approx(np.broadcast_to(np.array(velocity) * sim.time, begun.shape), abs=1e-10)
    assert body.frame()["tension"] == pytest.approx(tension, abs=1e-9 * 400.0 * 0.05)
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert abs(sim.budget.conservation()["energy"]) < 1e-9


@pytest.mark.parametrize("nodes", ["even", "material"])
def test_an_ellipse_becomes_rounder_and_every_balance_holds(nodes):
    sim = in_liquid(film(nodes=nodes))
    body = sim.bodies[0]
    mass, begun = body.arrays["mass"].sum(), ellipse_of(body.places()[:, :2]).deformation
    while sim.time < 0.3:
        sim.step()
    assert ellipse_of(body.places()[:, :2]).deformation < 0.97 * begun
    assert body.arrays["mass"].sum() == pytest.approx(mass, rel=1e-13)
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert abs(sim.budget.conservation()["energy"]) < 0.02  # of the transfer, first order in the step
    assert sim.budget.sums["viscous_heat"] > 0.0


def test_a_pressure_gives_no_momentum_to_a_closed_film():
    sim = in_liquid(pressure=[{"body": "film", "value": 5.0}])
    advance(sim, 40)
    assert np.abs(sim.bodies[0].totals.momentum + sim.bodies[1].totals.momentum).max() < 1e-12
    assert sim.budget.sums["load_work"] != 0.0


def test_a_vesicle_that_falls_on_a_floor_stops_there():
    """By contact of the field that it shares with the fluid inside."""
    down = (0.0, -1.0, 0.0)
    shape = {"ellipse": {"radius": 0.75, "centre": (2.5, 1.95, 0.0), "nodes": 40}}
    liquid = {
        "name": "liquid",
        "shape": {"cylinder": {"centre": (2.5, 1.95, 0.0), "radius": 0.7}},
        "points_per_cell": (2, 2, 1),
    }
    floor = box((0.5, 0.5, 0.0), (4.5, 1.0, 0.0), {**SOLID, "density": 2.0, "young_modulus": 100.0}, (2, 2, 1), name="floor")
    held = [{"name": "hold", "body": "floor", "hold": ["x", "y"]}]
    grid = {"counts": (20, 20, 0), "cell": 0.25, "functions": "quadratic-bspline", "end": 10.0, "courant": 0.2}
    bodies = film(shape, velocity=down), liquid | {"material": LIQUID, "velocity": down}, floor | {"field": "floor"}
    sim = simulation(*bodies, **grid, motion=held)
    while sim.time < 0.5:
        sim.step()
    lowest = sim.bodies[0].places()[:, 1].min()
    assert 1.0 - 0.1 * 0.25 < lowest < 1.15, "it fell from 1.2 by 0.5"
    assert sim.bodies[1].totals.momentum[1] > 0.7 * -sim.bodies[1].mass
    assert sim.budget.conservation()["momentum"] < 1e-12


def test_the_same_bits_on_two_threads_and_after_a_restart():
    one, two, late = in_liquid(), in_liquid(threads=2), in_liquid()
    for sim in (one, two):
        advance(sim, 20)
    late.restore({name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers())
    for sim in (one, two, late):
        advance(sim, 10)
    for other in (two, late):
        for name, array in one.state_arrays().items():
            assert other.state_arrays()[name].tobytes() == array.tobytes(), name


def test_a_film_in_space_resumes_too():
    """Its functions depend on more than its nodes."""
    surface = {"surface": {"sphere": {"centre": (2.0, 2.0, 2.0), "radius": 0.8, "divisions": 4}}}
    liquid = box((0.8, 0.8, 0.8), (3.2, 3.2, 3.2), LIQUID, (1, 1, 1), name="liquid")
    one, late = (simulation(film(surface), liquid, counts=(8, 8, 8), cell=0.5, end=1.0) for _ in range(2))
    advance(one, 6)
    late.restore({name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers())
    for sim in (one, late):
        advance(sim, 4)
    for name, array in one.state_arrays().items():
        assert late.state_arrays()[name].tobytes() == array.tobytes(), name


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"volume": {}}, "the fluid inside determines the volume"),
        ({"area": "kept"}, "set the `stiffness` of the material instead, which resists changes of the area"),
        ({"drag": {"normal": 1.0, "tangential": 1.0}}, "the surrounding fluid is computed"),
        ({"shape": {"spheroid": {"radius": 1.0, "nodes": 21}}}, "a surface of revolution cannot share"),
        ({"shape": {"ellipse": {"radius": 1.0, "nodes": 20}}}, "outside the grid"),
        ({"shape": {"ellipse": {"radius": 1.0, "centre": (2.5, 2.5, 0.0), "nodes": 8}}}, "fluid would pass between them"),
        (
            {"shape": BALL},
            "more than one cell thick",
        ),
        ({"initial": [{"kind": "polynomial"}]}, "but the points of this body do not have it"),
        ({"field": "own"}, "has its own velocity field and cannot touch body liquid"),
    ],
)
def test_what_does_not_go_with_a_shared_field(change, message):
    with pytest.raises(ValidationError, match=message):
        in_liquid(film(**change))


def test_no_motion_leads_its_nodes_along_the_normal():
    path = {"kind": "ramp", "distance": 0.1, "duration": 1.0}
    motion = [{"name": "swell", "body": "film", "displacement": {"normal": path}}]
    with pytest.raises(CaseError, match="the fluid around film film moves its nodes"):
        in_liquid(motion=motion)
