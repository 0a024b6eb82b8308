"""Steps that are foretold from the model of a case, against those that its simulation takes."""

import re

import numpy as np
import pytest
from elements import element_sheet
from membranes import sheet
from small_cases import GAS, SLIP, SOLID, box, case

from pellucid import load
from pellucid.case import Case
from pellucid.running.step_number import of_case, of_simulation
from pellucid.simulation.simulation import Simulation

WIDE = {"counts": (16, 16, 16), "cell": 0.25, "lower": (-2.0, -2.0, -2.0)}
VISCOUS = GAS | {"viscosity": 10.0}
DROPS = {"rigid": True, "velocity": [0.0, 0.0, -1.0]}
PLATE = box((0, 0, 0), (4, 4, 1), name="plate", rigid=True, field="plate")
CASES = {
    "a solid": case(box((1, 1, 1), (3, 3, 3))),
    "a solid that flies": case(box((1, 1, 1), (2, 2, 2), velocity=[5.0, 0.0, 0.0])),
    "a viscous gas": case(box((1, 1, 1), (3, 3, 3), VISCOUS), support=SLIP),
    "a fixed step": case(box((1, 1, 1), (3, 3, 3)), step=0.01, end=0.095),
    "under gravity": case(box((1, 1, 1), (3, 3, 3), SOLID | {"young_modulus": 1e-3}), gravity=(0, 0, -1e3)),
    "membrane points": case(sheet(), **WIDE),
    "quadrilaterals": case(element_sheet(), **WIDE),
    "triangles": case(element_sheet(elements="triangles", tension=500.0), **WIDE),
    "rigid bodies": case(PLATE, box((1, 1, 2), (3, 3, 3), **DROPS), gravity=(0, 0, -9.81)),
}


@pytest.mark.parametrize("name", CASES)
def test_the_model_foretells_the_step_of_the_simulation(name):
    ahead, simulation = of_case(CASES[name]), Simulation(CASES[name])
    found = of_simulation(simulation)
    assert ahead.step == pytest.approx(found.step, rel=1e-6)
    assert ahead.number == found.number
    assert ahead.why == found.why
    assert simulation.clock.next_step(simulation.bodies) == pytest.approx(found.step, rel=0.01)


@pytest.mark.parametrize("name", ["a solid", "a fixed step", "quadrilaterals"])
def test_as_many_steps_are_taken_as_were_foretold(name):
    simulation = Simulation(CASES[name])
    ahead = of_case(CASES[name])
    while not simulation.clock.finished(None):
        simulation.step()
    assert simulation.n_steps == pytest.approx(ahead.number, abs=1.0 + 0.01 * ahead.number)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("a solid", r"^limited by body `block` \(wave\): wave speed 3.669 m/s in cells of 1 m; time.courant = 0.4"),
        ("a solid that flies", r"\(motion\): speed 5 m/s through cells of 1 m"),
        ("a viscous gas", r"\(viscous\): kinematic viscosity 13.3 m2/s in cells of 1 m"),
        ("a fixed step", r"^time.step is 0.037 of the stable step of body `block`: wave"),
        ("under gravity", r"an object falling from rest crosses a cell in 0.0447 s"),
        ("membrane points", r"body `sheet` \(membrane\): in-plane wave speed 33.15 m/s in cells of 0.25 m"),
        ("quadrilaterals", r"\(membrane\): in-plane wave speed 33.15 m/s, smallest effective element size 0.118 m"),
        ("rigid bodies", r"\(contact\): oscillation of the body on its contacts, which limits the step to"),
    ],
)
def test_what_bounds_the_step_is_said_in_words(name, words):
    assert re.search(words, of_case(CASES[name]).why), of_case(CASES[name]).why


def test_compression_is_foretold_with_artificial_viscosity():
    shocked = GAS | {"artificial_viscosity": {"linear": 1.0}}
    calm, ahead = (of_case(case(box((1, 1, 1), (3, 3, 3), gas), support=SLIP)) for gas in (GAS, shocked))
    assert ahead.number == pytest.approx((1.0 + np.sqrt(2.0)) * calm.number, rel=0.2)


def test_films_alone_take_a_step_for_each_row_of_the_history():
    assert of_case(load("benet2015/ring").quick_variant()).number == 100


def test_nobody_foretells_steps_of_a_relaxation():
    ahead = of_case(load("mountris2019/cube-extension").with_settings({"steady.method": "relaxation"}))
    assert np.isnan(ahead.number)
    assert "their number is not known in advance" in ahead.why


def test_the_size_of_a_factored_stiffness_is_told():
    why = of_case(load("mountris2019/cube-extension", quick=True)).why
    assert "1 steady state with a factored stiffness of 1677 unknowns: 15.9 MB and about 0.1 s for each factorisation" in why


def test_rigid_bodies_that_loads_move_in_steady_states_are_named():
    steel = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
    ball = {"name": "ball", "field": "ball", "kind": "material-points", "rigid": True, "material": steel}
    ball |= {"shape": {"sphere": {"centre": [0.5, 0.5, 0.8], "radius": 0.2}}, "points_per_cell": 1}
    mesh = {"box": {"lower": [0, 0, 0], "upper": [1, 1, 0.5], "cells": [2, 2, 2]}}
    block = {"name": "block", "field": "block", "kind": "meshless-solid", "mesh": mesh, "material": steel}
    data = {"schema": 1, "title": "a test", "time": {"end": 1.0}, "steady": {}, "body": [block, ball]}
    data |= {"grid": {"lower": [0, 0, 0], "upper": [1, 1, 1.2], "cell": 0.1}, "gravity": [0, 0, -9.81]}
    data |= {"motion": [{"name": "guide", "body": "ball", "hold": ["y"], "hold_rotation": ["x", "y", "z"]}]}
    assert "The loads on the rigid body ball move it along x, z until" in of_case(Case.model_validate(data)).why


def test_until_an_earlier_time_there_are_fewer_steps():
    simulation = Simulation(CASES["a fixed step"])
    assert of_simulation(simulation, until=0.05).number == 5
    for _ in range(3):
        simulation.step()
    assert of_simulation(simulation, until=0.05).number == 2


def test_the_step_of_a_meshless_solid_is_that_of_its_simulation():
    """The frequencies of such a body follow from functions over the whole mesh, which its model does not have."""
    drop = load("basics/elastic-block-drop").quick_variant()
    simulation = Simulation(drop)
    body = simulation.bodies[0]
    assert body.step_limit().step == pytest.approx(1.0 / body.totals.rate)
    found = of_simulation(simulation)
    assert found.number == 112
    words = r"body `block` \(wave\): wave speed 10 m/s, smallest effective node spacing 0.0108 m"
    assert re.search(words, found.why)
    assert of_case(drop).why == "limited by body `block`; the time step is computed when the run starts"
