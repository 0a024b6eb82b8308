"""Bodies that can pass between the nodes of a sheet are warned of before they touch it, whatever their kind."""

import warnings

import numpy as np
import pytest
from small_cases import advance, box, case

from pellucid.set_up.coarse_bodies import coarse_sheets
from pellucid.simulation.simulation import Simulation

EDGE = 0.1
STIFF = {"kind": "neo-hookean", "density": 1000.0, "young_modulus": 1e5, "poisson_ratio": 0.3}
SHEET = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
LEVEL, MIDDLE = 0.5, 0.75  # of the sheet, and of one of its elements
QUIET = {"warn": 1e3, "stop": 1e4}


def round_body(kind, radius, height=0.05):
    """A body that falls on the middle of an element of the sheet, from a height over it."""
    centre = (MIDDLE, MIDDLE, LEVEL + radius + height)
    body = {"name": "ball", "field": "ball", "material": STIFF, "velocity": (0, 0, -1.0)}
    if kind == "meshless":
        low, high = (tuple(x + sign * radius for x in centre) for sign in (-1.0, 1.0))
        return body | {"kind": "meshless-solid", "mesh": {"box": {"lower": low, "upper": high, "cells": (3, 3, 3)}}}
    ball = body | {"shape": {"sphere": {"centre": centre, "radius": radius}}, "points_per_cell": (4, 4, 4)}
    return ball | ({"rigid": True} if kind == "rigid" else {})


def over_a_sheet(body, elements="quads"):
    edges = {"corner": (0.2, 0.2, LEVEL), "first_edge": (1.0, 0, 0), "second_edge": (0, 1.0, 0), "points": (11, 11)}
    sheet = {"name": "sheet", "field": "sheet", "kind": "membrane-elements", "elements": elements, "thickness": 0.002}
    held = [
        {"name": name, "body": "sheet", "part": {"box": {"lower": low, "upper": high}}, "hold": ["x", "y", "z"]}
        for name, low, high in (("left", (0, 0, 0), (0.21, 2, 2)), ("right", (1.19, 0, 0), (2, 2, 2)))
    ]
    sheet |= {"surface": {"rectangle": edges}, "material": SHEET, "tension": 100.0}
    return case(sheet, body, counts=(14, 14, 14), cell=EDGE, end=0.4, motion=held, energy=QUIET)


def told_in(of, steps):
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        sim = advance(Simulation(of, threads=1), steps)
    return sim, [text for text in (str(each.message) for each in told) if "it can pass between the nodes" in text]


@pytest.mark.parametrize("kind", ["rigid", "points", "meshless"])
def test_a_small_body_is_warned_of_before_it_passes(kind):
    """By validate from its extent, and by the run with the place; it does pass: a ball of 0.6 edges, a block of one edge."""
    radius = 0.6 * EDGE if kind != "meshless" else 0.49 * EDGE
    of = over_a_sheet(round_body(kind, radius))
    (before,) = coarse_sheets(of)
    assert f"body ball approaches membrane sheet with a part of {2.0 * (radius + 0.001):.3g} m in width" in before
    sim, (first, in_run) = told_in(of, 110)
    assert first == before
    assert in_run.startswith("step 100, ")
    most = float(in_run.split("edges of at most ")[1].split(" m ")[0])
    assert most == pytest.approx(radius, rel=0.1)
    place = [float(x) for x in in_run.split("near (")[1].split(")")[0].split(", ")]
    np.testing.assert_allclose(place, (MIDDLE, MIDDLE, LEVEL), atol=0.75 * EDGE)
    assert sim.bodies[1].places()[:, 2].mean() > LEVEL, "it has not passed yet"


def test_a_ball_that_the_nodes_stop_is_not():
    of = over_a_sheet(round_body("rigid", EDGE))
    assert list(coarse_sheets(of)) == []
    assert told_in(of, 110)[1] == []


@pytest.mark.parametrize("elements", ["quads", "triangles"])
def test_plates_and_blocks_that_fall_flat_are_not(elements):
    plate = box((0.0, 0.0, 0.52), (1.4, 1.4, 0.6), STIFF, None, name="plate", field="plate", velocity=(0, 0, -1))
    block = box((0.5, 0.5, 0.53), (0.9, 0.9, 0.7), STIFF, None, name="block", field="block", velocity=(0, 0, -1))
    for body in (plate, block):
        of = over_a_sheet(body, elements)
        assert list(coarse_sheets(of)) == []
        assert told_in(of, 110)[1] == []
