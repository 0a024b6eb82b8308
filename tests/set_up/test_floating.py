"""What is told of bodies that float in a liquid of their velocity field, and their draught in one of their own."""

import numpy as np
import pytest
from small_cases import box
from small_cases import case as case_of

from pellucid.set_up.first_look import look
from pellucid.set_up.floating import floating_bodies
from pellucid.simulation.simulation import Simulation

WATER = {"kind": "fluid", "density": 1000.0, "viscosity": 1e-3, "eos": {"kind": "tait", "sound_speed": 20.0}}
WOOD = {"kind": "linear-elastic", "density": 500.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
STONE = WOOD | {"density": 2500.0}
WALLS = {"where": ["x-lower", "x-upper", "y-lower"], "fix": "normal"}
LEVEL = 0.48


def afloat(material=WOOD, lower=0.32, liquid=WATER, gravity=(0, -9.81, 0), cell=0.04, motion=(), more=(), end=2.5, **options):
    """A box with edges of 0.2 m in water."""
    block = box((0.4, lower, 0), (0.6, lower + 0.2, 0), material, (3, 3, 1), "box", **options)
    rest = {"hydrostatic": {"level": LEVEL}} if liquid is WATER and any(gravity) else {}
    water = box((0, 0, 0), (1, LEVEL, 0), liquid, (3, 3, 1), "water", outside=["box"], **rest)
    counts = (round(1 / cell), round(0.8 / cell), 0)
    numbers = {"functions": "quadratic-bspline", "transfer": "apic", "end": end}
    tables = {"gravity": gravity, "motion": list(motion), "support": [WALLS, *more]}
    return case_of(water, block, counts=counts, cell=cell, **numbers, **tables)


GUIDE = {"name": "guide", "body": "box", "hold": ["x"], "hold_rotation": ["z"]}
LIFT = {"name": "lift", "body": "box", "hold": ["y"]}
PIN = {"where": {"box": {"lower": (0.35, 0.45, -1), "upper": (0.65, 0.7, 1)}}}


@pytest.mark.parametrize(
    "options",
    [
        {"rigid": True},
        {"rigid": True, "motion": [GUIDE]},
        {"material": STONE, "rigid": True, "lower": 0.5},
        {"lower": 0.2},
        {},
    ],
)
def test_a_body_that_may_float_is_told(options):
    (text,) = [text for text in look(afloat(**options)) if "floats too deep" in text]
    assert text.startswith("body box is in the velocity field of water")
    assert 'add field = "box" to body box' in text


@pytest.mark.parametrize(
    "options",
    [
        {"rigid": True, "field": "box"},
        {"rigid": True, "gravity": (0, 0, 0)},
        {"rigid": True, "motion": [LIFT]},
        {"more": [PIN]},
        {"material": STONE, "rigid": True, "lower": 0.2},
        {"material": STONE, "rigid": True, "lower": 0.0, "liquid": WATER | {"density": 900.0}},
    ],
)
def test_nothing_is_told_of_others(options):
    assert list(floating_bodies(afloat(**options))) == []


@pytest.mark.slow
@pytest.mark.parametrize("rigid", [{"rigid": True}, {}], ids=["rigid", "elastic"])
def test_the_remedy_gives_the_draught_of_archimedes(rigid):
    """Half as heavy as water: its middle lies at the level, 0.448 m + 0.02 m; in the field of the water 0.017 m below."""
    sim = Simulation(afloat(field="box", motion=[GUIDE] if rigid else [], **rigid))
    heights = [sim.bodies[1].places()[:, 1].mean() for _ in sim if sim.time > 1.5]
    assert np.mean(heights) == pytest.approx(0.468, abs=0.002)  # a twentieth of a cell
