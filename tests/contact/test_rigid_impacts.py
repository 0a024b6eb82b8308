"""Bodies of which none deforms stop each other, hardly rebound, and bear what lies on them."""

import warnings

import numpy as np
import pytest
from small_cases import RATE_SOLID, box, case

from pellucid.simulation.simulation import Simulation

RIGID = {"rigid": True, "points_per_cell": None}


def run(*bodies, end, cell=0.05, **more):
    """The simulation of a case in a slice 2 m wide after `end` [s], and the warnings of it."""
    size = {"counts": (round(2 / cell), round(1 / cell), 1), "cell": cell, "functions": "gimp", "thickness": 1.0}
    with warnings.catch_warnings(record=True) as said:
        warnings.simplefilter("always")
        sim = Simulation(case(*bodies, end=end, **size, **more), threads=1)
        while sim.time < end * (1.0 - 1e-9):
            sim.step()
    return sim, said


def disc(name, x, y, velocity=(0, 0, 0), radius=0.15):
    body = box((0, 0, 0), (1, 1, 0), RATE_SOLID, name=name, field=name, velocity=velocity) | RIGID
    return body | {"shape": {"cylinder": {"centre": (x, y, 0), "radius": radius, "height": 1.0}}}


def block(name, lower, upper, velocity=(0, 0, 0), density=1000.0):
    return box(lower, upper, RATE_SOLID | {"density": density}, name=name, field=name, velocity=velocity) | RIGID


def velocities(sim):
    return [body.totals.momentum[:2] / body.mass for body in sim.bodies]


@pytest.mark.parametrize("cell", [0.05, 0.025])
@pytest.mark.parametrize("kind", ["discs", "blocks"])
def test_two_go_on_together(kind, cell):
    """The damper of an impact lets go at some hundredths of its speed, in the steps of a run: 0.16 % of its energy."""
    one, two = (
        (disc("one", 0.5, 0.5, (2, 0, 0)), disc("two", 0.9, 0.5))
        if kind == "discs"
        else (block("one", (0.3, 0.4, 0), (0.6, 0.6, 0), (2, 0, 0)), block("two", (0.7, 0.4, 0), (1.0, 0.6, 0)))
    )
    sim, said = run(one, two, end=0.15, cell=cell)
    for velocity in velocities(sim):
        assert velocity == pytest.approx([1.0, 0.0], abs=0.04 * 2.0)
    assert not said


@pytest.mark.parametrize("cell", [0.05, 0.025])
def test_discs_that_meet_askew_exchange_what_is_normal_alone(cell):
    """Frictionless: centres 0.1 m apart across the way, and 0.3 m in all, so that the sine of the normal is a third."""
    sim, said = run(disc("one", 0.5, 0.45, (2, 0, 0)), disc("two", 1.1, 0.55), end=0.4, cell=cell)
    cosine, sine = np.sqrt(8.0) / 3.0, 1.0 / 3.0
    struck = velocities(sim)[1]
    assert struck == pytest.approx(cosine * np.array([cosine, sine]), abs=0.02)
    assert not said


def test_a_disc_stops_at_a_wall():
    wall = {"point": (0.9, 0, 0), "normal": (-1, 0, 0)}
    sim, said = run(disc("one", 0.5, 0.5, (2, 0, 0)), end=0.3, wall=[wall])
    assert abs(velocities(sim)[0][0]) < 0.05
    assert not said


@pytest.mark.parametrize("cell", [0.1, 0.05])
def test_a_light_body_bears_a_heavy_one(cell):
    """Two hundred times its mass, from the start: by its own weight alone the light one would sink in by that many times more
    than it does by itself, six hundredths of a cell, and the two would swing for long."""
    floor = block("floor", (0, 0, 0), (1.6, 0.2, 0)) | {"rigid": False}
    light = block("light", (0.5, 0.2, 0), (0.9, 0.4, 0), density=20.0)
    heavy = block("heavy", (0.5, 0.4, 0), (0.9, 0.6, 0), density=4000.0)
    hold = {"name": "hold", "body": "floor", "hold": ["x", "y", "z"]}
    sim, said = run(floor, light, heavy, end=0.3, cell=cell, motion=[hold], gravity=(0, -9.81, 0))
    low = [float(body.arrays["position"][:, 1].min()) for body in sim.bodies]
    sunk = np.array([0.2, 0.4]) - np.array(low[1:]) + 0.25 * cell
    assert np.all(sunk < [0.06 * cell, 0.12 * cell]), sunk / cell
    assert not [text for text in said if "contact" in str(text.message)]


def test_a_load_does_not_press_a_body_through_a_held_one():
    """A thousand times its weight."""
    floor = block("floor", (0, 0, 0), (1.6, 0.2, 0)) | {"rigid": False}
    pressed = block("pressed", (0.5, 0.2, 0), (0.9, 0.4, 0))
    hold = {"name": "hold", "body": "floor", "hold": ["x", "y", "z"]}
    push = {"kind": "rigid-force", "body": "pressed", "force": (0, -8e3, 0)}
    sim, _ = run(floor, pressed, end=0.2, motion=[hold], load=[push], gravity=(0, -0.1, 0))
    depth = 0.2 - (sim.bodies[1].arrays["position"][:, 1].min() - 0.0125)
    assert 0.0 < depth < 0.2 * 0.05


def test_a_plate_on_many_balls_rests():
    """Each ball answers to all that touch it: dampers that each take the whole approach would throw the plate."""
    floor = block("floor", (0, 0, 0), (2, 0.2, 0)) | {"rigid": False}
    balls = [disc(f"ball{i}", 0.3 + 0.35 * i, 0.35) for i in range(5)]
    plate = block("plate", (0.1, 0.5, 0), (1.9, 0.7, 0))
    hold = {"name": "hold", "body": "floor", "hold": ["x", "y", "z"]}
    sim, _ = run(floor, *balls, plate, end=0.25, motion=[hold], gravity=(0, -9.81, 0))
    assert abs(velocities(sim)[-1][1]) < 0.02
    assert sim.kinetic_energy() < 1.0
