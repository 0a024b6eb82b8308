"""Walls that are planes without a body: solids and fluids lie, slide and roll on them."""

import hashlib
import json
from math import cos, hypot, pi, sin, tan

import numpy as np
import pytest
from small_cases import GAS, SOLID, advance, box, simulation

from pellucid.case import Case
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

WALL = "slope"
G, SLOPE = 9.81, pi / 6
NORMAL = (sin(SLOPE), cos(SLOPE), 0.0)
HARD = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 4e6, "poisson_ratio": 0.3}
ELASTIC = {"kind": "linear-elastic", "density": 2000.0, "young_modulus": 1e7, "poisson_ratio": 0.3}
WATER = {"kind": "fluid", "density": 1000.0, "viscosity": 0.1, "eos": {"kind": "tait", "sound_speed": 30.0}}


def above(point, height):
    """The place so high above a point of the slope."""
    return tuple(a + height * n for a, n in zip(point, NORMAL, strict=True))


def disc(centre, **more):
    shape = {"cylinder": {"centre": centre, "radius": 0.4}}
    return {"name": "disc", "shape": shape, "points_per_cell": (3, 3, 1), "rigid": True, "material": HARD} | more


def slope(point, **more):
    return {"name": WALL, "point": point, "normal": NORMAL} | more


def finished(*bodies, **more):
    sim = simulation(*bodies, **({"gravity": (0, -G, 0)} | more))
    while not sim.clock.finished(None):
        sim.step()
    return sim


def mean_push(sim, since):
    """The mean force of the wall from an instant to the end [N]."""
    while sim.time < since:
        sim.step()
    before, time = sim.budget.reactions()[WALL], sim.time
    while not sim.clock.finished(None):
        sim.step()
    return (sim.budget.reactions()[WALL] - before) / (sim.time - time)


def motion(sim, k=0):
    """How far the middle of a body came [m], and its velocity [m/s], along the slope and away from it."""
    body = sim.bodies[k]
    mass = body.arrays["mass"]
    down = (cos(SLOPE), -sin(SLOPE), 0.0)
    velocity = body.totals.momentum / mass.sum()
    return np.array([velocity @ down, velocity @ NORMAL])


def middle(sim):
    body = sim.bodies[0]
    return body.arrays["mass"] @ body.arrays["position"] / body.arrays["mass"].sum()


def sound(sim, energy=1e-3):
    """Whether the balances close."""
    errors = sim.budget.conservation()
    return errors["mass"] == 0.0 and errors["momentum"] < 1e-12 and abs(errors["energy"]) < energy


def on_slope(friction, end=0.5):
    point = (0.8, 0.9, 0.0)
    wall = slope(point, **({"kind": "coulomb", "friction": friction} if friction else {}))
    more = {"counts": (20, 18, 0), "cell": 0.1, "functions": "quadratic-bspline"}
    return simulation(disc(above(point, 0.4)), gravity=(0, -G, 0), wall=[wall], end=end, **more)


@pytest.mark.parametrize(("friction", "slower"), [(0.6, 1.5), (0.0, 1.0)])
def test_a_rigid_disc_rolls_or_glides_down_as_fast_as_it_should(friction, slower):
    """With a = g sin α / 1.5 where it rolls."""
    sim = on_slope(friction)
    start = middle(sim)
    while not sim.clock.finished(None):
        sim.step()
    exact = G * sin(SLOPE) / slower
    assert motion(sim)[0] == pytest.approx(exact * 0.5, rel=0.005)
    assert hypot(*(middle(sim) - start)[:2]) == pytest.approx(0.5 * exact * 0.25, rel=0.01)
    assert sound(sim, 1e-12)
    assert sim.budget.energies()["contact_work"] < 0.0
    push = sim.budget.reactions()[WALL]
    weight = sim.bodies[0].mass * G
    assert push @ NORMAL == pytest.approx(0.5 * weight * cos(SLOPE), rel=0.01)


def test_it_glides_on_a_level_wall_without_loss():
    floor = {"point": (0, 0.2, 0), "normal": (0, 1, 0)}
    sim = finished(disc((0.6, 0.6, 0), velocity=(2, 0, 0)), counts=(26, 12, 0), cell=0.1, wall=[floor], end=0.5)
    assert motion(sim) @ (cos(SLOPE), sin(SLOPE)) == pytest.approx(2.0, rel=1e-9)
    assert sound(sim, 1e-12)


def test_a_ball_rolls_in_space():
    point = (0.7, 0.75, 0.5)
    ball = disc((0, 0, 0)) | {"points_per_cell": (3, 3, 3), "shape": {"sphere": {"centre": above(point, 0.3), "radius": 0.3}}}
    wall = slope(point, kind="coulomb", friction=0.6)
    sim = finished(ball, counts=(16, 14, 10), cell=0.1, functions="quadratic-bspline", wall=[wall], end=0.25)
    assert motion(sim)[0] == pytest.approx(G * sin(SLOPE) / 1.4 * 0.25, rel=0.01)
    assert sound(sim, 1e-12)


def block(point, **more):
    """An elastic block that lies on the slope."""
    x, y, _ = above(point, 0.125)
    shape = {"box": {"lower": (x - 0.25, y - 0.125, 0), "upper": (x + 0.25, y + 0.125, 0)}, "rotate": {"angle": -30}}
    return {"name": "block", "shape": shape, "points_per_cell": (2, 2, 1), "material": ELASTIC} | more


def test_an_elastic_block_slides_with_friction():
    """With a = g (sin α - μ cos α), from rest."""
    point = (0.8, 1.0, 0.0)
    wall = slope(point, kind="coulomb", friction=0.3)
    sim = finished(block(point), counts=(40, 28, 0), cell=0.05, wall=[wall], end=0.8)
    assert motion(sim)[0] == pytest.approx(0.8 * G * (sin(SLOPE) - 0.3 * cos(SLOPE)), rel=0.01)
    assert sound(sim)


@pytest.mark.parametrize("wall", [{"kind": "coulomb", "friction": 0.7}, {"kind": "stick"}], ids=["coulomb", "stick"])
def test_an_elastic_block_sticks(wall):
    point = (0.8, 1.0, 0.0)
    tables = simulation(block(point), counts=(30, 28, 0), cell=0.05, wall=[slope(point, **wall)], end=0.4).case.to_data()
    grows = {"times": (0, 0.2), "shares": (0, 1)}
    sim = Simulation(Case.model_validate(tables | {"gravity": (0, -G, 0), "gravity_amplitude": grows}), threads=1)
    start = middle(sim)
    push = mean_push(sim, 0.3)
    weight, shear = sim.bodies[0].mass * G, 1e7 / 2.6
    sheared = 0.5 * 2000.0 * G * sin(SLOPE) * 0.25**2 / shear
    assert hypot(*(middle(sim) - start)[:2]) < 1e-4 + sheared
    assert push == pytest.approx([0.0, weight, 0.0], abs=0.05 * weight)


def test_a_conveyor_carries_a_block_and_the_work_of_the_wall_is_counted():
    """By μ g until it is as fast; the motion does the work μ m g u t = m u²."""
    floor = {"point": (0, 0.2, 0), "normal": (0, 1, 0), "velocity": (1, 0, 0), "kind": "coulomb", "friction": 0.3}
    body = box((0.5, 0.2, 0), (1.0, 0.45, 0), ELASTIC, (2, 2, 1))
    sim = finished(body, counts=(36, 12, 0), cell=0.05, wall=[floor], end=0.5)
    mass = sim.bodies[0].mass
    energies = sim.budget.energies()
    assert sim.bodies[0].totals.momentum[0] / mass == pytest.approx(1.0, abs=0.01)
    assert energies["support_work"] == pytest.approx(mass, rel=0.01)
    assert energies["contact_work"] == pytest.approx(-0.5 * mass, rel=0.05)
    assert sound(sim)


@pytest.mark.parametrize("rigid", [True, False])
def test_a_wall_lifts_what_lies_on_it(rigid):
    floor = {"point": (0, 0.2, 0), "normal": (0, 1, 0), "velocity": (0, 0.5, 0)}
    body = box((0.5, 0.2, 0), (1.0, 0.45, 0), HARD, (2, 2, 1), rigid=rigid, damping=0.0 if rigid else 20.0)
    sim = finished(body, counts=(15, 15, 0), cell=0.1, wall=[floor], end=0.6)
    mass, start = sim.bodies[0].mass, 0.325
    assert middle(sim)[1] == pytest.approx(start + 0.3, abs=0.002)
    if rigid:
        assert sim.budget.energies()["support_work"] == pytest.approx(mass * (0.5**2 + G * 0.3), rel=0.01)
    assert sound(sim, 2e-3)


COLUMN = {"counts": (4, 12, 0), "cell": 0.1, "end": 1.5, "gravity": (0, -G, 0)}
SIDES = [{"where": f"x-{side}", "fix": "normal"} for side in ("lower", "upper")]


def column(bottom, **more):
    return box((0, bottom, 0), (0.4, bottom + 0.8, 0), WATER, (2, 2, 1), "water", damping=10.0, **more)


def by_height(sim):
    body = sim.bodies[0]
    order = np.argsort(body.field("position")[:, 1])
    return body.field("pressure")[order].reshape(-1, 8).mean(axis=1)


def test_water_lies_on_a_wall_as_on_a_support():
    """From the second cell on with the pressures on a face of the grid; below, half of the outermost layer's is missing. As the
    column comes to rest, points at the wall move with smoothed velocities, from which the transfers win 5e-5 of the energy."""
    floor = {"name": WALL, "point": (0, 0.2, 0), "normal": (0, 1, 0)}
    sim = simulation(column(0.2), support=SIDES, wall=[floor], **COLUMN)
    support = {"name": WALL, "where": "y-lower", "fix": "normal"}
    other = simulation(column(0.0), support=[*SIDES, support], **COLUMN)
    for held in (sim, other):
        assert mean_push(held, 1.3)[1] == pytest.approx(sim.bodies[0].mass * G, rel=0.005)
    pressure, expected = by_height(sim), by_height(other)
    assert pressure[2:-2] == pytest.approx(expected[2:-2], rel=0.01)
    assert pressure[:2] == pytest.approx(0.75 * expected[:2], rel=0.02)
    assert sound(sim, 2e-4)
    assert sound(other, 1e-12)


@pytest.mark.parametrize(
    ("wall", "kept"), [({}, 1.0), ({"kind": "stick"}, 0.3), ({"kind": "coulomb", "friction": 0.1}, 1.0 - 0.1 * G * 0.2)]
)
def test_water_slides_on_a_wall_as_it_should(wall, kept):
    """A shallow layer that moves at 1 m/s: on, or to a stand, or braked by μ g."""
    floor = {"point": (0, 0.2, 0), "normal": (0, 1, 0)} | wall
    layer = box((0.2, 0.2, 0), (2.2, 0.3, 0), WATER, (2, 2, 1), "water", velocity=(1, 0, 0))
    sim = finished(layer, counts=(30, 6, 0), cell=0.1, wall=[floor], end=0.2)
    velocity = sim.bodies[0].totals.momentum[0] / sim.bodies[0].mass
    if wall.get("kind") == "stick":
        assert velocity < kept
    else:
        assert velocity == pytest.approx(kept, rel=0.02)
    assert sim.budget.energies()["contact_work"] <= 0.0
    assert sound(sim, 1e-12)


@pytest.mark.parametrize(("per_cell", "courant"), [(2, 0.4), (4, 0.9)])
def test_water_that_falls_on_slopes_wins_no_energy(per_cell, courant):
    """Forces at the sides of the cubes of the points gave 10 to 40 % of it."""
    walls = [
        {"point": (0, 0.95, 0), "normal": NORMAL},
        {"point": (1.2, 0.25, 0), "normal": (-NORMAL[0], NORMAL[1], 0)},
        {"point": (0.1, 0, 0), "normal": (1, 0, 0)},
    ]
    water = box((0.1, 1, 0), (0.6, 1.5, 0), WATER, (per_cell, per_cell, 1), "water")
    sides = [{"where": face, "fix": "normal"} for face in ("x-upper", "y-upper")]
    sim = finished(water, counts=(30, 20, 0), cell=0.1, support=sides, wall=walls, end=1.2, courant=courant)
    scale = sim.budget.energy_scale
    assert -0.5 * scale < sim.budget.energies()["contact_work"] < 0.0
    assert sound(sim, 1e-12)
    x = sim.bodies[0].arrays["position"]
    for wall in walls:
        height = (x - wall["point"]) @ np.array(wall["normal"])
        assert height.min() > -0.03
        assert np.quantile(height, 0.1) > 0.0


def mixed(threads=1, end=10.0):
    """A rigid disc, an elastic block and water on one wall that moves, in fields of their own."""
    wall = {"point": (0, 0.2, 0), "normal": (0, 1, 0), "kind": "coulomb", "friction": 0.4, "velocity": (0.2, 0.1, 0)}
    bodies = [
        disc((0.6, 0.6, 0), field="disc"),
        box((1.2, 0.2, 0), (1.7, 0.5, 0), ELASTIC, (2, 2, 1), field="block"),
        box((2, 0.2, 0), (2.8, 0.8, 0), WATER, (2, 2, 1), "water", field="water"),
    ]
    more = {"counts": (40, 16, 0), "cell": 0.1, "end": end, "gravity": (0, -G, 0)}
    return simulation(*bodies, wall=[wall | {"name": "belt"}], threads=threads, **more)


def fingerprint(sim):
    digest = hashlib.sha256()
    for name, array in sorted(sim.state_arrays().items()):
        digest.update(name.encode() + array.tobytes())
    return digest.hexdigest() + json.dumps([sim.state_numbers(), sim.budget.energies(), sim.budget.conservation()])


def test_threads_do_not_change_a_bit():
    one, two = (advance(mixed(threads), 60) for threads in (1, 2))
    assert one.budget.reactions()["belt"][1] > 0.0
    assert fingerprint(one) == fingerprint(two)


def test_a_checkpoint_goes_on_bit_for_bit():
    straight = advance(mixed(), 60)
    arrays = {name: array.copy() for name, array in straight.state_arrays().items()}
    numbers = json.loads(json.dumps(straight.state_numbers()))
    other = advance(mixed(), 3)
    other.restore(arrays, numbers)
    assert fingerprint(advance(other, 30)) == fingerprint(advance(straight, 30))


def test_a_wall_stops_only_the_bodies_that_it_names():
    bodies = [box((0.2, 0.4, 0), (0.6, 0.8, 0), SOLID, (2, 2, 1), name, velocity=(0, -1, 0)) for name in ("one", "two")]
    bodies[1]["shape"] = {"box": {"lower": (1.4, 0.4, 0), "upper": (1.8, 0.8, 0)}}
    wall = {"name": "floor", "point": (0, 0.35, 0), "normal": (0, 1, 0), "bodies": ["two"]}
    sim = finished(*bodies, counts=(20, 10, 0), cell=0.1, wall=[wall], end=0.25, gravity=(0, 0, 0))
    assert sim.bodies[0].arrays["position"][:, 1].min() < 0.2
    assert sim.bodies[1].arrays["position"][:, 1].min() > 0.3
    assert sim.budget.reactions()["floor"] == pytest.approx(sim.momentum() - sim.budget.initial_momentum, abs=1e-12)


STIFF = HARD | {"young_modulus": 1e6}


@pytest.mark.parametrize("functions", ["gimp", "quadratic-bspline"])
@pytest.mark.parametrize(("axis", "side"), [(0, "upper"), (1, "lower")])
@pytest.mark.parametrize("material", [STIFF, WATER], ids=["solid", "fluid"])
def test_a_wall_on_a_face_of_the_grid_stops_what_strikes_it(material, axis, side, functions):
    """At an eighth to a quarter of the speed of sound: points pass the plane, and the grid has room for them behind it."""
    speed = 8.0 if material is STIFF else 5.0
    lower, normal, velocity, place = [0.3, 0.3, 0], [0, 0, 0], [0, 0, 0], [0, 0, 0]
    lower[axis], place[axis], way = (0.05, 0.0, -1.0) if side == "lower" else (0.55, 1.0, 1.0)
    normal[axis], velocity[axis] = -way, way * speed
    body = box(lower, [lower[0] + 0.4, lower[1] + 0.4, 0], material, (2, 2, 1), velocity=velocity)
    sides = [{"where": f"{'yx'[axis]}-{end}", "fix": "normal"} for end in ("lower", "upper")]
    wall = {"point": place, "normal": normal}
    sim = simulation(body, counts=(10, 10, 0), cell=0.1, functions=functions, support=sides, wall=[wall], end=0.04)
    depth = 0.0
    while not sim.clock.finished(None):
        sim.step()
        depth = max(depth, (sim.bodies[0].arrays["position"][:, axis] - place[axis]).max() * way)
    assert depth < 0.05
    assert sim.bodies[0].totals.momentum[axis] * way < 0.5 * sim.bodies[0].mass * speed
    assert sound(sim, 0.05)


def test_a_meshless_solid_strikes_a_wall_on_a_face_of_the_grid():
    mesh = {"box": {"lower": (0.3, 0.3, 0.55), "upper": (0.7, 0.7, 0.95), "cells": (3, 3, 3)}}
    body = {"name": "block", "kind": "meshless-solid", "mesh": mesh, "material": STIFF, "velocity": (0, 0, 2)}
    wall = {"point": (0, 0, 1), "normal": (0, 0, -1)}
    sim = finished(body, counts=(10, 10, 10), cell=0.1, wall=[wall], end=0.05, gravity=(0, 0, 0))
    assert 1.0 < sim.bodies[0].arrays["position"][:, 2].max() < 1.01
    assert sound(sim, 0.01)


def refused(*bodies, **wall):
    with pytest.raises(CaseError) as caught:
        simulation(*bodies, counts=(10, 10, 0), cell=0.1, wall=[{"normal": (0, 1, 0)} | wall])
    return str(caught.value)


@pytest.mark.parametrize("material", [SOLID, WATER], ids=["solid", "fluid"])
def test_a_body_that_starts_behind_a_wall_is_refused(material):
    body = box((0.2, 0.2, 0), (0.6, 0.6, 0), material, (2, 2, 1))
    text = refused(body, point=(0, 0.25, 0))
    for words in (
        "wall.0.point",
        "body block starts 0.05 m behind this wall",
        "quarter of a cell, 0.025 m",
        "set `normal` to point",
    ):
        assert words in text
    simulation(body, counts=(10, 10, 0), cell=0.1, wall=[{"normal": (0, 1, 0), "point": (0, 0.22, 0)}])


def test_friction_is_no_kind():
    body = box((0.2, 0.3, 0), (0.6, 0.6, 0), SOLID, (2, 2, 1))
    with pytest.raises(ValueError, match='"friction" is not a kind of contact; use kind = "coulomb"'):
        simulation(body, counts=(10, 10, 0), cell=0.1, wall=[{"point": (0, 0.2, 0), "normal": (0, 1, 0), "kind": "friction"}])


def test_a_gas_is_refused():
    body = box((0.2, 0.2, 0), (0.6, 0.6, 0), GAS, (2, 2, 1))
    text = refused(body, point=(0, 0.2, 0))
    for words in (
        "wall.0.bodies",
        "would press it 0.71 cells into the wall",
        "limit: 0.1",
        "a gas cannot be in contact with a wall",
    ):
        assert words in text


def test_a_wall_that_no_body_can_touch_is_refused():
    rectangle = {"corner": (0.2, 0.5, 0.2), "first_edge": (0.5, 0, 0), "second_edge": (0, 0, 0.5), "points": (11, 11)}
    skin = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e4, "poisson_ratio": 0.3}
    sheet = {
        "name": "sheet",
        "kind": "membrane-points",
        "surface": {"rectangle": rectangle},
        "thickness": 0.01,
        "material": skin,
    }
    for names, words in (
        ((), "no body of this case can touch it"),
        (("sheet",), 'body sheet of kind "membrane-points" cannot have contact'),
    ):
        with pytest.raises(ValueError, match=words):
            simulation(
                sheet, counts=(10, 10, 10), cell=0.1, wall=[{"normal": (0, 1, 0), "point": (0, 0.1, 0), "bodies": names}]
            )


def test_a_driven_body_goes_through_a_wall():
    """It follows its motion whatever happens, and nothing pushes it."""
    body = box((0.2, 0.1, 0), (0.6, 0.5, 0), SOLID, (2, 2, 1))
    hold = {"name": "hold", "body": "block", "hold": ["x", "y"]}
    other = box((0.2, 0.6, 0), (0.6, 0.8, 0), SOLID, (2, 2, 1), "other", field="other")
    wall = {"name": "floor", "point": (0, 0.3, 0), "normal": (0, 1, 0)}
    sim = advance(simulation(body, other, counts=(10, 10, 0), cell=0.1, wall=[wall], motion=[hold], end=1.0), 5)
    assert len(sim.parts.only(SurfacePairs)) == 2, "the two bodies, and the other on the wall"
    assert not sim.budget.reactions()["floor"].any()


@pytest.mark.slow
def test_a_slope_of_its_angle_of_friction_is_the_limit():
    """A disc that may not turn has none: a block with μ just above tan α stays, just below it slides."""
    point = (0.8, 1.0, 0.0)
    rigid = block(point, rigid=True)
    speeds = []
    for friction in (1.1 * tan(SLOPE), 0.9 * tan(SLOPE)):
        wall = slope(point, kind="coulomb", friction=friction)
        sim = finished(rigid, counts=(30, 28, 0), cell=0.05, wall=[wall], end=0.2)
        speeds.append(motion(sim)[0])
    assert abs(speeds[0]) < 1e-3
    assert speeds[1] == pytest.approx(0.2 * G * 0.1 * sin(SLOPE), rel=0.05)
