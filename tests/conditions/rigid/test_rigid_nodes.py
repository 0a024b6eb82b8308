"""Rigid bodies in the velocity field of a fluid: what they exchange with it on the nodes."""

import json

import numpy as np
import pytest
from small_cases import SOLID, advance, box, case

from pellucid.simulation.simulation import Simulation

OIL = {"kind": "fluid", "density": 1000.0, "viscosity": 1000.0}
OIL |= {"eos": {"kind": "tait", "sound_speed": 20.0, "carries_tension": True}}
FEW = {"warn": 0.5, "stop": 10.0}
PLANE, SPACE = (12, 12, 1), (9, 9, 9)


def stirred(*bodies, upper=(9.0, 9.0, 0), per_cell=(3, 3, 1), counts=PLANE, threads=1, **more):
    """Bodies in a free block of oil, which no wall holds."""
    names = [body["name"] for body in bodies]
    oil = box((3.0, 3.0, 3.0 if counts[2] > 1 else 0), upper, OIL, per_cell, name="oil", outside=names)
    how = {"counts": counts, "functions": "quadratic-bspline", "transfer": "apic", "energy": FEW, "end": 10.0}
    return Simulation(case(*bodies, oil, **(how | more)), threads=threads)


def paddle(turn=(0, 0, 2.0), **more):
    return box((4.2, 4.0, 0), (6.2, 7.0, 0), SOLID, (3, 3, 1), rigid=True, angular_velocity=turn, velocity=(0.3, 0, 0), **more)


def turning(sim):
    """Angular momentum about the origin of all points, with that of their affine fields [N m s], (3,)."""
    return sum(body.angular_momentum(np.zeros(3)).vector for body in sim.bodies)


@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
def test_a_paddle_and_its_fluid_keep_momentum_and_angular_momentum(scheme):
    """It slows down by far, and the fluid has what it loses: to rounding over some hundred steps."""
    sim = stirred(paddle(), scheme=scheme)
    start = turning(sim)
    advance(sim, 150)
    kept = sim.budget.conservation()
    assert kept["angular_momentum"] < 1e-12
    assert kept["momentum"] < 1e-12
    assert abs(kept["energy"]) < 1e-12
    assert turning(sim) == pytest.approx(start, rel=1e-10, abs=1e-8)
    assert sim.bodies[0].constraint.rates()[5] < 0.5


def test_a_brick_in_space_and_its_fluid_keep_angular_momentum():
    brick = box((4.2, 4.1, 4), (5.7, 6, 5.3), SOLID, (2, 2, 2), rigid=True, angular_velocity=(1.0, 0.3, 2.0))
    sim = stirred(brick, upper=(8.0, 8.0, 8.0), per_cell=(2, 2, 2), counts=(11, 11, 11))
    start = turning(sim)
    advance(sim, 60)
    assert turning(sim) == pytest.approx(start, rel=1e-10)
    assert sim.budget.conservation()["angular_momentum"] < 1e-12
    assert abs(sim.budget.conservation()["energy"]) < 1e-12


@pytest.mark.parametrize("functions", ["trilinear", "gimp", "cubic-bspline"])
@pytest.mark.parametrize("transfer", ["flip", "blend", "pic", "apic"])
def test_momentum_and_energy_are_kept_with_every_transfer(transfer, functions):
    sim = stirred(paddle(), transfer=transfer, functions=functions)
    begin = sim.kinetic_energy()
    advance(sim, 60)
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert abs(sim.budget.conservation()["energy"]) < 1e-12
    assert sim.kinetic_energy() < begin


def test_two_bodies_that_reach_the_same_nodes_keep_momentum():
    """They lie half a cell apart in one velocity field, with the fluid between them."""
    left = box((4.0, 4.0, 0), (5.5, 6.0, 0), SOLID, (3, 3, 1), name="left", rigid=True, angular_velocity=(0, 0, 1.0))
    right = box((6.0, 4.0, 0), (7.5, 6.0, 0), SOLID, (3, 3, 1), name="right", rigid=True, velocity=(0, 0.5, 0))
    for transfer in ("apic", "flip"):
        sim = stirred(left, right, transfer=transfer)
        start = turning(sim)
        advance(sim, 60)
        assert sim.budget.conservation()["momentum"] < 1e-12
        assert abs(sim.budget.conservation()["energy"]) < 1e-12
        if transfer == "apic":
            assert turning(sim) == pytest.approx(start, rel=1e-10, abs=1e-8)


@pytest.mark.parametrize("transfer", ["apic", "pic"])
def test_the_torque_on_a_rotor_is_what_its_fluid_gains(transfer):
    """The motion that turns it at a steady rate gives all the angular momentum of rotor and oil. PIC smooths some away."""
    turn = {"name": "turn", "body": "block", "hold": ["x", "y"], "rotation": {"z": {"kind": "steady", "angular_velocity": 1.0}}}
    sim = stirred(paddle() | {"velocity": (0, 0, 0), "angular_velocity": (0, 0, 0)}, motion=[turn], transfer=transfer)
    advance(sim, 100)
    given, path = sim.budget.angular_reactions()["turn"][2], sim.budget.reactions()["turn"]
    centre = np.array([5.2, 5.5, 0.0])
    about = turning(sim) - np.cross(centre, sim.momentum())
    if transfer == "apic":
        assert about[2] == pytest.approx(given, rel=1e-10)
    else:
        assert 0.2 * given < about[2] < given
    assert sim.momentum() == pytest.approx(path, abs=1e-9)
    assert abs(sim.budget.conservation()["energy"]) < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize(
    ("centre", "cells", "share_of_step", "tolerance"),
    [
        ((0.0, 0.0), 5, 1.0, 0.01),
        ((0.3, 0.2), 5, 1.0, 0.01),
        ((0.5, 0.5), 5, 1.0, 0.01),
        ((0.5, 0.0), 5, 1.0, 0.01),
        ((0.3, 0.2), 5, 0.5, 0.01),
        pytest.param((0.3, 0.2), 5, 0.25, 0.01, marks=pytest.mark.full),
        pytest.param((0.0, 0.0), 10, 1.0, 0.003, marks=pytest.mark.full),
        pytest.param((0.5, 0.5), 10, 1.0, 0.003, marks=pytest.mark.full),
    ],
)
def test_the_torque_of_couettes_flow(centre, cells, share_of_step, tolerance):
    """Between a rotor and a fixed wall of four radii: 4 π μ ω R₁² R₂²/(R₂² - R₁²), wherever in a cell the centre lies, and
    whatever the step is."""
    cell = 0.25 / cells
    middle = [cell * centre[0], cell * centre[1], 0]
    ring = {"pipe": {"centre": middle, "outer_radius": 1.0, "inner_radius": 0.25}}
    water = {"kind": "fluid", "density": 1.0, "viscosity": 1.0, "eos": OIL["eos"] | {"sound_speed": 10.0}}
    fluid = {"name": "fluid", "shape": ring, "points_per_cell": (3, 3, 1), "material": water}
    shape = {"cylinder": {"centre": middle, "radius": 0.25}}
    rotor = {"name": "rotor", "shape": shape, "points_per_cell": (3, 3, 1), "material": SOLID | {"density": 1.0}, "rigid": True}
    turn = {"name": "turn", "body": "rotor", "hold": ["x", "y"]}
    turn["rotation"] = {"z": {"kind": "steady", "angular_velocity": 1.0}}
    support = [{"where": {"pipe": {"centre": middle, "inner_radius": 1.0, "outer_radius": 2.0}}}]
    how = {
        "counts": (round(2.2 / cell), round(2.2 / cell), 1),
        "cell": cell,
        "courant": 0.4 * share_of_step,
        "lower": (-1.1, -1.1, 0.0),
        "functions": "quadratic-bspline",
        "transfer": "apic",
    }
    sim = Simulation(case(fluid, rotor, motion=[turn], support=support, end=1.0, energy=FEW, **how), threads=1)
    while sim.time < 0.3:
        sim.step()
    before, since = sim.budget.angular_reactions()["turn"][2], sim.time
    while sim.time < 0.4:
        sim.step()
    torque = (sim.budget.angular_reactions()["turn"][2] - before) / (sim.time - since)
    assert torque == pytest.approx(4.0 * np.pi * 0.25**2 / (1.0 - 0.25**2), rel=tolerance)


def test_bits_do_not_depend_on_threads_and_a_checkpoint_goes_on_in_a_fluid():
    one, two = (stirred(paddle(), transfer="flip", threads=threads) for threads in (1, 2))
    advance(one, 20)
    advance(two, 20)
    again = stirred(paddle(), transfer="flip")
    numbers = json.loads(json.dumps(one.state_numbers()))
    again.restore({name: array.copy() for name, array in one.state_arrays().items()}, numbers)
    advance(again, 110)
    advance(two, 110)
    for body, other in zip(again.bodies, two.bodies, strict=True):
        for name, array in body.arrays.items():
            assert np.array_equal(array, other.arrays[name])
    assert again.budget.conservation() == two.budget.conservation()
