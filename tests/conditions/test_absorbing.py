"""Absorbing faces let pulses out."""

import numpy as np
import pytest
from small_cases import RATE_SOLID, box, case

from pellucid.case import Case
from pellucid.conditions.absorbing import AbsorbingFaces
from pellucid.simulation.simulation import Simulation

LENGTH, WIDTH = 80, 8.0  # cells, and half the width of the pulse
LIQUID = {
    "kind": "fluid",
    "density": 1000.0,
    "pressure": 0.0,
    "energy_update": "midpoint",
    "eos": {"kind": "stiffened-gas", "gruneisen": 4.0, "p_infinity": 2e4},
}
FACES = ["x-lower", "x-upper"]


def bar(material, functions="trilinear", faces=FACES, per_cell=2, **more):
    body = box((0, 0, 0), (LENGTH, 1, 1), material, name="bar", per_cell=(per_cell, 1, 1))
    table = case(
        body, counts=(LENGTH, 1, 1), functions=functions, end=1e3, energy={"warn": 9.0, "stop": 10.0}, **more
    ).to_data()
    table["absorbing"] = [{"where": list(faces), "body": "bar"}] if faces else []
    return table


def what_comes_back(table, direction=0):
    """Largest velocity after a pulse has met the faces, over its amplitude there."""
    sim = Simulation(Case.model_validate(table), threads=1)
    body = sim.bodies[0]
    along = body.arrays["position"][:, 0] - 0.5 * LENGTH
    body.arrays["velocity"][:, direction] = 1e-3 * np.exp(-((along / WIDTH) ** 2))
    speed = Case.model_validate(table).body[0].material.wave_speeds()[min(direction, 1)]
    sim.budget.moved = np.inf  # the pulse was given after the balance began
    while sim.time < 0.95 * LENGTH / speed:
        sim.step()
    half = 0.5e-3  # a pulse of velocity alone splits in two
    return np.abs(body.arrays["velocity"][:, direction]).max() / half


@pytest.mark.parametrize("functions", ["trilinear", "gimp", "quadratic-bspline", "cubic-bspline"])
def test_a_pulse_leaves_a_liquid(functions):
    """What is promised: less than 2 % comes back."""
    assert what_comes_back(bar(LIQUID, functions)) < 0.02


def test_without_absorption_it_all_comes_back():
    assert what_comes_back(bar(LIQUID, faces=[])) > 0.9


def test_a_pressure_pulse_leaves_a_solid():
    assert what_comes_back(bar(RATE_SOLID)) < 0.02


def test_a_shear_pulse_leaves_a_solid():
    """Along y, in the plane: y is free to move and everything is the same along it."""
    table = bar(RATE_SOLID)
    table["grid"]["upper"] = [LENGTH, 2.0, 1.0]
    table["body"][0]["shape"]["box"]["upper"] = [LENGTH, 2.0, 1.0]
    table["body"][0]["points_per_cell"] = [2, 2, 1]
    table["support"] = [{"where": "all-nodes", "fix": ["x"]}]
    assert what_comes_back(table, direction=1) < 0.02


def test_the_balance_closes():
    table = bar(LIQUID)
    table["body"][0]["velocity_wave"] = {"amplitude": (1e-3, 0, 0), "wave_vector": (2 * np.pi / LENGTH, 0, 0), "phase": 0.0}
    sim = Simulation(Case.model_validate(table), threads=1)
    while sim.time < 1.5 * LENGTH / 10.0:
        sim.step()
    energies = sim.budget.energies()
    assert energies["absorbed_energy"] > 0.5 * sim.budget.initial["kinetic"]
    assert abs(sim.budget.energy_error()) < 0.01  # the error of a step is of its second order
    assert sim.budget.conservation()["momentum"] < 1e-12


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"body": "baar"}, "no body has this name; available names: bar"),
        ({"where": ["x-lower", "w-upper"]}, "w-upper|literal|one of"),
        ({"where": []}, "where"),
        ({"where": ["x-lower", "x-lower"]}, "is listed twice"),
    ],
)
def test_faces_that_make_no_sense(change, words):
    table = bar(LIQUID)
    table["absorbing"][0] |= change
    with pytest.raises(ValueError, match=words):
        Case.model_validate(table)


def test_a_held_face_absorbs_nothing():
    table = bar(LIQUID)
    table["support"] = [{"where": "x-lower", "fix": "normal"}]
    with pytest.raises(ValueError, match="constrained nodes cannot absorb waves"):
        Case.model_validate(table)


def test_absorbing_faces_are_a_part_of_the_step_that_damps_their_nodes_alone():
    sim = Simulation(Case.model_validate(bar(LIQUID, faces=["x-upper"])), threads=1)
    assert len(sim.parts.of(AbsorbingFaces)) == 1
    rates, (index, position) = sim.velocity_fields[0].external.absorption, sim.grid.where()
    on_face = position[:, 0] == LENGTH
    assert (rates[index[on_face], 0] > 0.0).all()
    assert not rates[index[~on_face]].any()
