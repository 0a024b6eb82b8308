"""Meshless solids and membranes of elements touch by surfaces: what glides and rolls, walls, energy, and fluids in bags."""

import numpy as np
import pytest
from small_cases import RATE_SOLID, advance, box, simulation

from pellucid.contact.overlap import SHEET_STIFF
from pellucid.contact.pairs import ContactPairs
from pellucid.contact.surface_pairs import SurfacePairs
from pellucid.running.step_number import of_simulation

G = 9.81
SKIN = {"kind": "linear-membrane", "density": 1000.0, "young_modulus": 1e7, "poisson_ratio": 0.3}
RUBBER = {"kind": "neo-hookean", "density": 2000.0, "young_modulus": 1e6, "poisson_ratio": 0.3}
FLOOR = {"point": (0, 0, 0), "normal": (0, 0, 1)}


def blown_up(centre=(0.3, 0.2, 0.2), **more):
    """A ball of membrane of a radius of 0.2 m that a pressure of 20 kPa keeps taut."""
    return {
        "name": "ball",
        "field": "ball",
        "kind": "membrane-elements",
        "elements": "triangles",
        "surface": {"icosphere": {"centre": centre, "radius": 0.2, "refinements": 2}},
        "thickness": 0.004,
        "tension": 2000.0,
        "material": SKIN,
    } | more


def plate():
    return box((0, 0, -0.1), (1.2, 0.4, 0), RATE_SOLID | {"young_modulus": 1e6}, None, name="plate", field="plate")


SIZE = {"lower": (0.0, -0.1, -0.1), "counts": (12, 6, 6), "cell": 0.1}
PRESSURE = [{"body": "ball", "value": 20e3}]


@pytest.mark.parametrize("on", ["plate", "wall"])
def test_a_blown_up_ball_glides_without_loss(on):
    """Exact: 2 m/s. The ball swings on what it lies on, and contact takes below 0.5 % of the energy of its motion."""
    ground = {"motion": [{"name": "still", "body": "plate", "hold": ["x", "y", "z"]}]} if on == "plate" else {"wall": [FLOOR]}
    bodies = [blown_up(velocity=(2, 0, 0)), *([plate()] if on == "plate" else [])]
    sim = simulation(*bodies, pressure=PRESSURE, gravity=(0, 0, -G), end=0.2, **SIZE, **ground)
    assert not len(sim.parts.only(ContactPairs))
    while not sim.clock.finished(None):
        sim.step()
    ball, energy = sim.bodies[0], sim.parts.only(SurfacePairs).energy
    moving = 0.5 * ball.mass * 2.0**2
    assert ball.totals.momentum / ball.mass == pytest.approx([2.0, 0.0, 0.0], abs=0.15)
    assert ball.totals.momentum[0] / ball.mass == pytest.approx(2.0, rel=1e-3)
    assert energy.work != 0.0
    assert 0.0 < energy.taken < 0.005 * moving
    assert abs(energy.unexplained) < 1e-3 * moving
    assert abs(ball.arrays["position"][:, 2].min()) < 0.01


@pytest.mark.slow
def test_a_meshless_ball_rolls_down_a_wall():
    """Gravity grows within 0.2 s; then v = 5/7 g sin 30° (t - 0.1). The mean over two swings on the wall, within 2 %."""
    mesh = {"fill": {"shape": {"sphere": {"centre": (0.4, 0.2, 0.2), "radius": 0.2}}, "size": 0.05}}
    ball = {"name": "ball", "field": "ball", "kind": "meshless-solid", "mesh": mesh, "material": RUBBER}
    slope = (G * 0.5, 0.0, -G * np.sqrt(0.75))
    grown = {"times": [0, 0.2], "shares": [0, 1]}
    wall = FLOOR | {"kind": "coulomb", "friction": 0.6}
    more = {"gravity": slope, "gravity_amplitude": grown, "wall": [wall], "end": 0.5}
    sim = simulation(ball, lower=(0.0, -0.1, -0.1), counts=(12, 6, 6), cell=0.1, **more)
    over = []
    while not sim.clock.finished(None):
        sim.step()
        if sim.time > 0.35:
            over.append(sim.bodies[0].totals.momentum[0] / sim.bodies[0].mass / (5.0 / 7.0 * G * 0.5 * (sim.time - 0.1)))
    assert np.mean(over) == pytest.approx(1.0, abs=0.02)
    moving = sim.bodies[0].totals.kinetic
    assert abs(sim.parts.only(SurfacePairs).energy.unexplained) < 0.01 * moving


def test_a_blown_up_ball_rolls_down_a_wall():
    """Four cells in its radius, gravity grown within 0.2 s; then v = 3/5 g sin 30° (t - 0.1) as of a thin shell, within 1 %.

    The mean over some swings: contact takes 0.2 % of the energy, and the ball is flattened by 0.4 % of its radius.
    """
    surface = {"icosphere": {"centre": (0.3, 0.3, 0.202), "radius": 0.2, "refinements": 3}}
    slope = (G * 0.5, 0.0, -G * np.sqrt(0.75))
    grown = {"times": [0, 0.2], "shares": [0, 1]}
    wall = FLOOR | {"kind": "coulomb", "friction": 0.6}
    grid = {"lower": (0.0, -0.1, -0.1), "counts": (22, 16, 14), "cell": 0.05}
    more = {"gravity": slope, "gravity_amplitude": grown, "wall": [wall], "pressure": PRESSURE, "end": 0.4}
    sim = simulation(blown_up(surface=surface), **grid, **more)
    ball, over = sim.bodies[0], []
    while not sim.clock.finished(None):
        sim.step()
        if sim.time > 0.25:
            over.append(ball.totals.momentum[0] / ball.mass / (0.6 * G * 0.5 * (sim.time - 0.1)))
    assert np.mean(over) == pytest.approx(1.0, abs=0.01)
    energy = sim.parts.only(SurfacePairs).energy
    assert 0.0 < energy.taken < 0.005 * ball.totals.kinetic
    assert abs(energy.unexplained) < 1e-3 * ball.totals.kinetic


def test_what_dampers_take_that_stop_nodes_within_a_step_is_explained():
    """A sheet falls flat on a wall and hardly rebounds: by the spring of the way that its nodes come in within a step, 0.25."""
    rectangle = {"corner": (0.2, 0.1, 0.02), "first_edge": (0.4, 0, 0), "second_edge": (0, 0.2, 0), "points": (9, 5)}
    sheet = blown_up(surface={"rectangle": rectangle}, tension=0.0, velocity=(0.5, 0, -1))
    sim = simulation(sheet, wall=[FLOOR], end=0.05, **SIZE)
    while not sim.clock.finished(None):
        sim.step()
    energy, body = sim.parts.only(SurfacePairs).energy, sim.bodies[0]
    velocity = body.totals.momentum / body.mass
    assert velocity[0] == pytest.approx(0.5, rel=1e-9)
    assert 0.0 < velocity[2] < 0.25
    assert energy.taken == pytest.approx(0.5 * body.mass * (1.0 - velocity[2] ** 2), rel=1e-6)
    assert abs(energy.unexplained) < 1e-9 * energy.taken


def test_steps_do_not_outgrow_the_springs_of_contact():
    sim = simulation(blown_up(), wall=[FLOOR], end=0.1, pressure=PRESSURE, **SIZE)
    body, (wall,) = sim.bodies[0], sim.parts.only(SurfacePairs)._pairs
    longest = sim.case.time.courant / body.contact_rate
    assert np.sqrt(wall.law.stiffness / body.areal_density) * longest == pytest.approx(SHEET_STIFF)
    body.totals.rate = 0.0
    body.update(0.0)
    assert body.totals.rate >= body.contact_rate
    free = simulation(blown_up(), end=0.1, pressure=PRESSURE, **SIZE)
    assert free.bodies[0].contact_rate == 0.0


def test_a_fixed_step_bounds_the_stiffness():
    step = 2e-5
    sim = simulation(blown_up(), wall=[FLOOR], end=0.1, step=step, pressure=PRESSURE, **SIZE)
    (wall,) = sim.parts.only(SurfacePairs)._pairs
    assert np.sqrt(wall.law.stiffness / sim.bodies[0].areal_density) * step == pytest.approx(SHEET_STIFF)


def test_a_ball_that_starts_half_its_thickness_in_a_plate_is_not_thrown_off():
    """Its lowest node lies on the plate: by half of its thickness it overlaps, with a force of 30 kN if that pressed."""
    still = [{"name": "still", "body": "plate", "hold": ["x", "y", "z"]}]
    sim = simulation(blown_up(), plate(), pressure=PRESSURE, motion=still, end=0.1, **SIZE)
    advance(sim, 200)
    assert np.abs(sim.bodies[0].totals.momentum).max() < 0.01 * sim.bodies[0].mass


WATER = {"kind": "fluid", "density": 1000.0, "viscosity": 0.001, "eos": {"kind": "tait", "sound_speed": 20.0}}


def bag(of_water):
    """A bag, with water in it or around it in its velocity field, that falls on a plate."""
    sphere = {"sphere": {"centre": (0.6, 0.2, 0.155), "radius": 0.15, "divisions": 8}}
    skin = blown_up(surface=sphere, elements="quads", velocity=(0, 0, -1), tension=0.0)
    water = box((0, 0, 0), (1, 1, 1), WATER, name="water", field="ball") | {"velocity": (0, 0, -1)}
    around = {"sphere": {"centre": (0.6, 0.2, 0.205), "radius": 0.2}}
    water |= {"shape": {"inside": {"surface": sphere}} if of_water == "inside" else around}
    still = [{"name": "still", "body": "plate", "hold": ["x", "y", "z"]}]
    return simulation(skin, water, plate(), motion=still, end=0.1, lower=(0, -0.1, -0.1), counts=(24, 12, 12), cell=0.05)


def test_a_bag_of_water_touches_by_its_surface():
    sim = bag("inside")
    assert len(sim.parts.only(SurfacePairs)) == 1
    assert not len(sim.parts.only(ContactPairs))
    while sim.time < 0.03:
        sim.step()
    assert sim.parts.only(SurfacePairs).energy.taken > 0.0
    assert sim.bodies[0].places()[:, 2].min() > -0.01
    assert sim.bodies[1].totals.momentum[2] / sim.bodies[1].mass > -0.95
    assert sim.budget.conservation()["momentum"] < 1e-12
    kept, numbers = {name: array.copy() for name, array in sim.state_arrays().items()}, sim.state_numbers()
    other = bag("inside")
    other.restore(kept, numbers)
    for one in (sim, other):
        advance(one, 5)
    assert all(np.array_equal(array, sim.state_arrays()[name]) for name, array in other.state_arrays().items())


def test_water_around_a_bag_touches_on_the_nodes():
    sim = bag("around")
    assert not len(sim.parts.only(SurfacePairs))
    assert len(sim.parts.only(ContactPairs))


@pytest.mark.parametrize("density", [500.0, 3.0])
def test_the_step_that_contact_asks_for_is_foretold(density):
    """A rigid ball that is light beside the sheet on which it falls swings faster than waves cross the sheet."""
    rectangle = {"corner": (0, -0.1, 0), "first_edge": (0.6, 0, 0), "second_edge": (0, 0.6, 0), "points": (19, 19)}
    sheet = blown_up(surface={"rectangle": rectangle}, tension=0.0, thickness=0.001, field="sheet", name="sheet")
    sphere = {"sphere": {"centre": (0.3, 0.2, 0.11), "radius": 0.1}}
    rigid = box((0, 0, 0), (1, 1, 1), RATE_SOLID | {"density": density}, name="rigid", field="rigid", rigid=True)
    sim = simulation(sheet, rigid | {"shape": sphere}, end=0.01, **SIZE)
    foretold, first = of_simulation(sim), sim.clock.next_step(sim.bodies)
    assert foretold.step == pytest.approx(first, rel=1e-6)
    assert ("(contact)" in foretold.why) == (density < 100.0)
