"""Supports that meet at edges and corners: nothing passes a wall, and the order of their tables changes no bit."""

from itertools import permutations

import numpy as np
import pytest
from small_cases import advance, box, simulation

from pellucid.errors import RunStopped

WATER = {
    "kind": "fluid",
    "density": 1.0,
    "viscosity": 0.01,
    "eos": {"kind": "tait", "sound_speed": 10.0, "carries_tension": True},
}
SOLID = {"kind": "neo-hookean", "density": 1.0, "young_modulus": 100.0, "poisson_ratio": 0.3}
LID = {"name": "lid", "where": "y-upper", "velocity": (1, 0, 0)}
SIDES = {"name": "sides", "where": ["x-lower", "x-upper"]}
SLIP_SIDES = SIDES | {"fix": "normal"}
FLOOR = {"name": "floor", "where": "y-lower"}
ENDS = {"name": "ends", "where": ["z-lower", "z-upper"]}
STRIP = {"name": "strip", "where": {"box": {"lower": (-1, 0.999, -1), "upper": (2, 1.001, 2)}}, "velocity": (1, 0, 0)}


def cavity(supports, cells=8, deep=0, steps=40, **more):
    """Positions and reactions after some steps."""
    upper, counts = (1, 1, deep / cells), (cells, cells, deep)
    per_cell = (2, 2, 2 if deep else 1)
    water = box((0, 0, 0), upper, WATER, per_cell)
    options = {"functions": "quadratic-bspline", "transfer": "apic", "end": 9.0} | more
    sim = simulation(water, counts=counts, cell=1.0 / cells, support=supports, **options)
    advance(sim, steps)
    body = sim.bodies[0]
    position = body.places()
    assert position[:, :2].min() >= 0.0
    assert position[:, :2].max() <= 1.0
    assert sim.budget.conservation()["momentum"] < 1e-12
    return position, body.frame()["velocity"], sim.budget.reactions()


def same_bits(results):
    first, *others = results
    for other in others:
        assert all(np.array_equal(a, b) for a, b in zip(first[:2], other[:2], strict=True))
        assert all(np.array_equal(first[2][name], other[2][name]) for name in first[2])


@pytest.mark.parametrize("sides", [SIDES, SLIP_SIDES], ids=["held", "slip"])
def test_a_cavity_in_the_plane(sides):
    same_bits([cavity(order) for order in permutations([LID, sides, FLOOR])])


def test_a_cavity_in_space():
    orders = [[LID, SIDES, FLOOR, ENDS], [ENDS, FLOOR, SIDES, LID], [SIDES, LID, ENDS, FLOOR]]
    same_bits([cavity(order, cells=4, deep=4, steps=30) for order in orders])


def test_two_lids_that_meet():
    wheel = {"where": "x-upper", "velocity": (0, -1, 0)}
    others = {"where": ["x-lower", "y-lower"]}
    same_bits([cavity(order) for order in permutations([LID, wheel, others])])


def test_a_lid_that_a_region_describes():
    """Its nodes in the corners stay with the walls beside it."""
    with pytest.warns(UserWarning, match="because it closes a face of the grid"):
        moved = cavity([SIDES, FLOOR, {"where": "y-upper", "fix": "normal"}, STRIP])
    with pytest.warns(UserWarning, match="because it closes a face of the grid"):
        other = cavity([STRIP, {"where": "y-upper", "fix": "normal"}, FLOOR, SIDES])
    same_bits([moved, other])


def test_a_piston_beside_a_floor_that_holds():
    """Along its own normal each face moves as it is given, whatever the other one holds."""
    piston = {"name": "piston", "where": "x-lower", "velocity": (0.3, 0, 0)}
    rest = {"where": ["x-upper", "y-lower", "y-upper"]}
    same_bits([cavity(order) for order in permutations([piston, rest])])


def test_a_meshless_solid_between_walls():
    """Nodes of a body at an edge of the grid."""
    grip = {"where": "y-upper", "velocity": (0.5, 0, 0)}
    floor, sides = {"where": "y-lower"}, {"where": ["x-lower", "x-upper", "z-lower", "z-upper"], "fix": "normal"}
    mesh = {"box": {"lower": (0, 0, 0), "upper": (1, 1, 1), "cells": (2, 2, 2)}}
    block = {"name": "block", "kind": "meshless-solid", "mesh": mesh, "material": SOLID}
    found = []
    for order in permutations([grip, floor, sides]):
        sim = advance(simulation(block, counts=(2, 2, 2), cell=0.5, support=order, end=9.0), 20)
        found.append(sim.bodies[0].places())
    assert all(np.array_equal(found[0], other) for other in found[1:])
    start = found[0][:, 0].min(), found[0][:, 0].max()
    assert start == (pytest.approx(0.0, abs=1e-12), pytest.approx(1.0, abs=1e-12))


def test_walls_that_are_planes():
    """Sums over them do not depend on the order of their tables."""
    planes = [
        {"point": (0.1, 0, 0), "normal": (1, 0.2, 0)},
        {"point": (0, 0.1, 0), "normal": (0.1, 1, 0), "kind": "coulomb", "friction": 0.3},
        {"point": (0.9, 0, 0), "normal": (-1, 0, 0)},
    ]
    water = box((0.125, 0.125, 0), (0.875, 0.5, 0), WATER, (2, 2, 1))
    found = []
    for order in permutations(planes):
        options = {"counts": (8, 8, 0), "cell": 0.125, "functions": "quadratic-bspline", "transfer": "apic", "end": 9.0}
        sim = advance(simulation(water, gravity=(-1.0, -3.0, 0), wall=order, **options), 150)
        found.append(sim.bodies[0].places())
    assert all(np.array_equal(found[0], other) for other in found[1:])


def test_a_point_that_passes_a_held_face_says_so():
    sim = simulation(box((0, 0, 0), (1, 1, 0), WATER, (2, 2, 1)), counts=(8, 8, 0), cell=0.125, support=[FLOOR], end=9.0)
    sim.bodies[0].arrays["position"][0, 1] = -0.01
    with pytest.raises(RunStopped, match="crossed the face y-lower, which a support constrains along its normal"):
        sim.bodies[0].stop(3, 0, 1, 0.0)
