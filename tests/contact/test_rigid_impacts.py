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


@pytest.mark.parametrize("cell", [0.05, pytest.param(0.025, marks=pytest.mark.slow)])
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


@pytest.mark.parametrize("cell", [0.05, pytest.param(0.025, marks=pytest.mark.slow)])
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


@pytest.mark.parametrize("cell", [0.1, pytest.param(0.05, marks=pytest.mark.slow)])
def test_a_light_body_bears_a_heavy_one(cell):
    """Two hundred times its mass, from the start: by its own weight alone the light one would sink in by that many times more
    than it does by itself, six hundredths of a cell, and the two would swing for long."""
    floor = block("floor", (0, 0, 0), (1.6, 0.2, 0)) | {"rigid": False}
    light = block("light", (0.5, 0.2, 0), (0.9, 0.4, 0), density=20.0)
    heavy = block("heavy", (0.5, 0.4, 0), (0.9, 0.6, 0), density=4000.0)
    hold = {"name": "hold", "body": "floor", "hold": ["x", "y", "z"]}
    sim, said = run(floor, light, heavy, end=0.2, cell=cell, motion=[hold], gravity=(0, -9.81, 0))
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


@pytest.mark.slow
def test_a_plate_on_many_balls_rests():
    """Each ball responds to all that touch it: dampers that each take the whole approach would throw the plate."""
    floor = block("floor", (0, 0, 0), (2, 0.2, 0)) | {"rigid": False}
    balls = [disc(f"ball{i}", 0.3 + 0.35 * i, 0.35) for i in range(5)]
    plate = block("plate", (0.1, 0.5, 0), (1.9, 0.7, 0))
    hold = {"name": "hold", "body": "floor", "hold": ["x", "y", "z"]}
    sim, _ = run(floor, *balls, plate, end=0.15, motion=[hold], gravity=(0, -9.81, 0))
    assert abs(velocities(sim)[-1][1]) < 0.02
    assert sim.kinetic_energy() < 1.0


@pytest.mark.parametrize("angle", [20.0, 45.0])
@pytest.mark.parametrize("on", ["wall", "plate"])
def test_a_corner_stops_and_the_block_turns_about_it(angle, on):
    """Without friction: the impulse J at the corner, at a lever r from the middle, ends its approach, v = J (1/m + r²/I)."""
    along, up = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    lever, height = 0.3 * along - 0.1 * up, 0.3 * up + 0.1 * along
    turned = block("one", (0.7, 0.25 + height - 0.1, 0), (1.3, 0.25 + height + 0.1, 0), (0, -2, 0))
    turned["shape"]["rotate"] = {"angle": angle, "axis": (0, 0, 1)}
    floor = block("floor", (0, 0, 0), (2, 0.2, 0)) | {"rigid": False}
    hold = {"name": "hold", "body": "floor", "hold": ["x", "y", "z"]}
    wall = {"point": (0, 0.2, 0), "normal": (0, 1, 0)}
    sim, said = run(turned, end=0.045, wall=[wall]) if on == "wall" else run(turned, floor, end=0.045, motion=[hold])
    per_mass, per_inertia = 1.0 / 120.0, 1.0 / (120.0 * (0.6**2 + 0.2**2) / 12.0)
    impulse = 2.0 / (per_mass + per_inertia * lever**2)
    assert velocities(sim)[0][1] == pytest.approx(-2.0 + per_mass * impulse, rel=0.08)
    body = sim.bodies[0].arrays
    arm, velocity = body["position"] - body["position"].mean(axis=0), body["velocity"]
    spin = np.sum(arm[:, 0] * velocity[:, 1] - arm[:, 1] * velocity[:, 0]) / np.sum(arm[:, 0] ** 2 + arm[:, 1] ** 2)
    assert abs(spin) == pytest.approx(per_inertia * impulse * lever, rel=0.08)
    assert not [text for text in said if "contact" in str(text.message)]


def test_one_that_lies_on_a_wall_and_moves_towards_it_stops_without_a_warning():
    """Its overlap is one of rounding, and the first step has none before it."""
    wall = {"point": (0, 0.2, 0), "normal": (0, 1, 0)}
    sim, said = run(block("one", (0.3, 0.2, 0), (0.7, 0.4, 0), (0, -1, 0)), end=0.1, wall=[wall])
    assert abs(velocities(sim)[0][1]) < 0.04
    assert not said
