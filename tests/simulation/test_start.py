"""Bodies that start nearer to each other than contact allows."""

import json
import warnings

import numpy as np
import pytest
from membranes import sheet
from pressed_oocytes import FORCES, RADIUS, THICKNESS, WAYS, force_on_plate, pressed_oocyte
from small_cases import SOLID, advance, box, case, simulation

from pellucid.case import Case
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.contact.touch import OverlappingStart
from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

SPEED = 0.02
LOUD = {"warn": 1e3, "stop": 1e4}


def built(table):
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        return Simulation(Case.model_validate(table), threads=1), [str(warning.message) for warning in caught]


@pytest.mark.parametrize(
    ("plate", "offset", "clear"),
    [
        ("wall", None, 0.5e-6),  # half of the thickness
        ("wall", 0.0, 0.5e-6),
        ("wall", None, -3.7e-6),  # the plate starts within the contact distance: contact acts 3.7 um later
        pytest.param("sheet", None, 0.5e-6, marks=pytest.mark.slow),
        ("sheet", None, -3.7e-6),
    ],
)
def test_the_force_on_a_pressed_sphere_is_exact(plate, offset, clear):
    """Within 5 % at five displacements since the faces touched, or since the start.

    The mesh is coarse: eight divisions along a quarter of a great circle.
    """
    reach = 0.5 * THICKNESS if offset is None else offset
    given = {} if offset is None else {"contact_offset": offset}
    reach += 0.5e-6 if plate == "sheet" else 0.0  # half of its thickness
    sim, told = built(pressed_oocyte(RADIUS + reach + clear, SPEED, plate=plate, **given))
    depth = max(-clear, 0.0)
    assert [overlap.depth for overlap in sim.parts.only(SurfacePairs).start_overlaps] == pytest.approx(
        [depth] if depth else [], rel=1e-9
    )
    assert len(told) == len(sim.parts.only(SurfacePairs).start_overlaps)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of the size of the elements
        way, force = force_on_plate(sim, SPEED)
    found = np.interp(WAYS + max(clear, 0.0), way, force)
    assert found == pytest.approx(FORCES, rel=0.05)
    assert abs(sim.budget.conservation()["energy"]) < 1e-3


def test_the_report_names_both_and_the_depth():
    sim, (text,) = built(pressed_oocyte(RADIUS + 0.3e-6, contact_offset="4 um"))
    assert text == (
        "body zona and wall plate start 3.7e-06 m closer to each other than the contact distance of 4e-06 m (`contact_offset` "
        "of each membrane, default: half of the thickness): this overlap exerts no force until they have separated once, so "
        "contact starts 3.7e-06 m late. To have contact act from the start, move one of the two away by 3.7e-06 m, or set a "
        "smaller `contact_offset`."
    )
    (fact,) = sim.facts()["start_overlaps"]
    assert fact == {"between": ["body zona", "wall plate"], "depth": pytest.approx(3.7e-6), "distance": pytest.approx(4e-6)}
    assert json.loads(json.dumps(fact)) == fact


def test_without_thickness_there_is_no_contact_distance():
    """Where thickness goes to zero contact acts at the mid-surface, as with `contact_offset = 0`."""
    thin = {"thickness": 1e-12, "material": {"kind": "linear-membrane", "density": 1e9, "young_modulus": 1e13}}
    thin["material"]["poisson_ratio"] = 0.3
    bodies = [sheet(field="sheet", kind="membrane-elements", **thin, **more) for more in ({}, {"contact_offset": 0.0})]
    wall = {"point": (0, 0, 0.04), "normal": (0, 0, -1), "velocity": (0, 0, -1.0)}
    forces = []
    for body in bodies:
        sim = simulation(body, counts=(8, 8, 8), cell=0.25, lower=(-1, -1, -1), wall=[wall], end=0.05, energy=LOUD)
        assert not sim.parts.only(SurfacePairs).start_overlaps
        advance(sim, 60)
        forces.append(sim.bodies[0].arrays["velocity"][:, 2])
    assert forces[0].min() < -0.1, "the wall came up to it, and pushes"
    assert forces[0] == pytest.approx(forces[1], abs=1e-6)


PLATE = box((0, 0, 2), (4, 4, 3), name="plate", field="plate")
LED = [{"name": "hold", "body": "plate", "hold": ["x", "y", "z"]}]


def meshless(top):
    mesh = {"box": {"lower": (1, 1, 0.5), "upper": (3, 3, top), "cells": (4, 4, 3)}}
    material = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e5, "poisson_ratio": 0.3}
    return {"name": "tissue", "kind": "meshless-solid", "field": "tissue", "mesh": mesh, "material": material}


def membrane(top):
    table = sheet(edges=((2, 0, 0), (0, 2, 0)), field="tissue", kind="membrane-elements", thickness=0.2) | {"name": "tissue"}
    table["surface"]["rectangle"]["corner"] = (1, 1, top - 0.1)
    return table


def points(top):
    return box((1, 1, top - 1.5), (3, 3, top), SOLID, name="tissue", field="tissue")


def led_sheet():
    table = sheet(edges=((4, 0, 0), (0, 4, 0)), field="plate", kind="membrane-elements", thickness=0.1) | {"name": "plate"}
    table["surface"]["rectangle"]["corner"] = (0, 0, 2.05)
    return table


@pytest.mark.parametrize("other", ["plate", "wall", "sheet"])
@pytest.mark.parametrize("body", [meshless, membrane, points])
def test_what_overlaps_at_the_start_is_not_thrown_off(body, other):
    """Nothing moves, since nothing pushes: no gravity, no motion."""
    settings = {"counts": (4, 4, 4), "end": 100.0, "energy": LOUD}
    table = body(2.06)
    if other == "wall":
        settings["wall"] = [{"name": "lid", "point": (0, 0, 2), "normal": (0, 0, -1)}]
        bodies = (table,)
    else:
        settings["motion"], bodies = LED, (table, PLATE if other == "plate" else led_sheet())
    with pytest.warns(UserWarning, match=r"body tissue .*0\.06 m"):
        sim = simulation(*bodies, **settings)
    (overlap,) = sim.parts.only(SurfacePairs).start_overlaps
    assert overlap.depth == pytest.approx(0.06, abs=0.001)
    assert set(overlap.between) == {"body tissue", "wall lid" if other == "wall" else "body plate"}
    advance(sim, 20)
    assert np.abs(sim.bodies[0].arrays["velocity"]).max() < 1e-9
    assert sim.budget.energies()["contact_work"] == pytest.approx(0.0, abs=1e-12)


def coming(velocity, sheet=False):
    """A membrane that starts 0.06 m within the distance at which it touches a plate or sheet, and moves."""
    table, other = membrane(2.06) | {"velocity": velocity}, led_sheet() if sheet else PLATE
    with pytest.warns(UserWarning, match="body tissue"):
        return simulation(table, other, counts=(4, 4, 4), motion=LED, step=1e-3, end=100.0, energy=LOUD)


@pytest.mark.parametrize("sheet", [False, True])
def test_it_presses_once_it_has_come_apart(sheet):
    apart = coming((0, 0, -1.0), sheet)
    start = apart.bodies[0].arrays["position"][0, 2]
    advance(apart, 100)  # 0.1 m
    assert apart.parts.only(SurfacePairs)._pairs[0].start_depth() == 0.0
    apart.bodies[0].arrays["velocity"][:] = (0.0, 0.0, 1.0)
    advance(apart, 100)
    assert apart.bodies[0].arrays["position"][:, 2].max() < start - 0.05, "stopped where contact acts"


@pytest.mark.parametrize("sheet", [False, True])
def test_a_run_goes_on_bit_for_bit_with_its_start_overlap(sheet):
    whole = advance(coming((0, 0, 0.5), sheet), 10)
    kept = {name: array.copy() for name, array in whole.state_arrays().items()}
    numbers = json.loads(json.dumps(whole.state_numbers()))
    again = coming((0, 0, 0.5), sheet)
    again.restore(kept, numbers)
    for sim in (whole, again):
        advance(sim, 10)
    assert np.array_equal(whole.bodies[0].arrays["velocity"], again.bodies[0].arrays["velocity"])
    assert whole.bodies[0].arrays["velocity"][:, 2].min() < 0.5, "the plate stopped it"


def test_bodies_that_continue_an_earlier_run_press_from_the_start_on():
    settings = {"counts": (4, 4, 4), "step": 1e-3, "end": 100.0, "energy": LOUD}
    whole = case(membrane(2.06), wall=[{"name": "lid", "point": (0, 0, 2), "normal": (0, 0, -1)}], **settings)
    with pytest.warns(UserWarning, match="body tissue and wall lid"):
        first = Simulation(whole, threads=1)
    sim = Simulation(whole, threads=1, start={"tissue": first.bodies[0].state_arrays()})
    assert not sim.parts.only(SurfacePairs).start_overlaps
    advance(sim, 5)
    assert sim.bodies[0].arrays["velocity"][:, 2].max() < -1e-3


def test_a_body_that_touches_itself_is_reported_by_its_name():
    text = OverlappingStart(("body bag",), 2e-4, 1e-3).text
    assert text.startswith("parts of body bag start up to 0.0002 m closer to each other than twice the contact offset")


def test_an_offset_beyond_the_sight_of_surfaces_is_refused():
    table = membrane(2.06) | {"contact_offset": 3.0}
    with pytest.raises(CaseError, match=r"body\.tissue\.contact_offset.*\n.*the contact distance of .* is 3 m") as caught:
        simulation(table, PLATE, counts=(4, 4, 4), motion=LED, end=1.0)
    assert "Set a smaller `contact_offset`" in str(caught.value)
