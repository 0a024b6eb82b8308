"""Rigid bodies: their motion, and what soil, walls and contact do to them."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from small_cases import RATE_SOLID, SLIP, SOLID, advance, box, case

from pellucid.conditions.rigid.kinematics import inertia_of
from pellucid.simulation.simulation import Simulation

PULL = 10.0  # m/s²
GROUND = [wall for wall in SLIP[:4] if wall["where"] != "y-upper"]
SIZE = {"counts": (8, 8, 1), "thickness": 1.0, "energy": {"warn": 0.5, "stop": 10.0}}
WATER = {"kind": "fluid", "density": 1000.0, "eos": {"kind": "tait", "sound_speed": 20.0}}


def rigid(lower, upper, **more):
    return box(lower, upper, SOLID, (2, 2, 1), name="block", rigid=True, **more)


def on_soil(functions, field, settle=None, **more):
    """A block of 2 cells on soil of 3 cells, with which it shares nodes or which it touches."""
    soil = SOLID | {"young_modulus": 1e6}
    bodies = box((0, 0, 0), (8, 3, 0), soil, (2, 2, 1), name="soil"), rigid((3, 3, 0), (5, 5, 0), field=field)
    found = case(*bodies, functions=functions, support=GROUND, gravity=(0, -PULL, 0), **(SIZE | {"end": 3.0} | more))
    return type(found).model_validate(found.to_data() | {"settle": settle}) if settle is not None else found


GIVES_WAY = {"common": 0.0, "block": SOLID["density"] * 2.0 * PULL / 1.346e6}
"""Of a cell, under the weight of the block: where it touches by its surface, contact gives way as a layer of cells of the soil,
by the pressure over ρ c² = E (1 - ν) / ((1 + ν) (1 - 2 ν))."""


def sunk(sim):
    """How far the block reaches below the top of the soil beneath it [m]."""
    soil, block = (body.arrays["position"] for body in sim.bodies)
    beneath = soil[(soil[:, 0] > 3.3) & (soil[:, 0] < 4.7), 1]
    return beneath.max() + 0.25 - (block[:, 1].min() - 0.25)


@pytest.mark.parametrize("functions", ["trilinear", "gimp", "quadratic-bspline"])
@pytest.mark.parametrize("field", ["common", "block"])
def test_a_rigid_block_lies_on_soil(functions, field):
    """Over five swings, where the force reaches twice the weight, it sinks no deeper than contact gives way, and no energy is
    lost that is not told. Nodes that bodies share hold it within two hundredths of a cell."""
    sim = Simulation(on_soil(functions, field), threads=1)
    deepest, start = 0.0, sim.bodies[1].frame()["position"]
    while not sim.clock.finished(None):
        sim.step()
        deepest = max(deepest, sunk(sim))
    assert deepest < max(0.02, 1.1 * 2.0 * GIVES_WAY[field])
    assert np.abs(sim.bodies[1].frame()["position"] - start).max() < 0.2, "the soil bears it"
    assert abs(sim.budget.energy_error()) < 0.02
    assert sim.budget.conservation()["momentum"] < 1e-12


@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_a_wall_bears_a_rigid_block(functions):
    """It rests, and the support has its weight."""
    support = [wall | {"name": wall["where"]} for wall in GROUND]
    found = case(rigid((3, 0, 0), (5, 2, 0)), functions=functions, support=support, gravity=(0, -PULL, 0), end=0.4, **SIZE)
    sim = Simulation(found, threads=1)
    first = sim.bodies[0].frame()["position"]
    while not sim.clock.finished(None):
        sim.step()
    assert np.abs(sim.bodies[0].frame()["position"] - first).max() < 1e-12
    weight = sim.bodies[0].mass * PULL
    assert sim.budget.reactions()["y-lower"][1] == pytest.approx(0.4 * weight, rel=1e-12)
    assert sim.budget.conservation()["momentum"] < 1e-12


def test_a_block_that_falls_on_a_wall_stays_there_and_can_leave_it():
    """Its impact has no rebound; thrown upwards it goes, as the wall pushes alone."""
    block = rigid((3, 1, 0), (5, 3, 0), velocity=(0.0, -2.0, 0.0))
    sim = Simulation(case(block, support=GROUND, end=10.0, step=0.05, **SIZE), threads=1)
    start = sim.kinetic_energy()
    while sim.time < 2.0:
        sim.step()
    body = sim.bodies[0]
    assert abs(body.arrays["position"][:, 1].min() - 0.25) < 0.2
    assert np.abs(body.arrays["velocity"]).max() < 0.02
    energies = sim.budget.energies()
    assert energies["impact_heat"] + energies["transfer_heat"] == pytest.approx(start, rel=0.02)
    body.arrays["velocity"][:, 1] = 1.0
    before = body.arrays["position"][:, 1].mean()
    until = sim.time + 2.0
    while sim.time < until:
        sim.step()
    assert body.arrays["position"][:, 1].mean() - before > 1.5


@pytest.mark.parametrize("courant", [0.2, 0.9])
def test_a_rigid_block_that_falls_on_a_held_one_stays_there(courant):
    """It comes at 1.4 m/s, and goes back by a tenth of that at most: the damper is critical for the whole of the block."""
    floor = box((0, 0, 0), (2, 0.3, 0), SOLID, (2, 2, 1), name="floor", field="floor")
    block = rigid((0.5, 0.4, 0), (1.5, 0.9, 0), field="block")
    hold = {"name": "hold", "body": "floor", "hold": ["x", "y", "z"]}
    size = {"counts": (20, 20, 1), "cell": 0.1, "thickness": 1.0}
    sim = Simulation(case(floor, block, motion=[hold], gravity=(0, -9.81, 0), end=1.0, courant=courant, **size), threads=1)
    rising = []
    while sim.time < 0.4:
        sim.step()
        rising.append(sim.bodies[1].arrays["velocity"][:, 1].mean())
    assert min(rising) == pytest.approx(-((2.0 * 9.81 * 0.1) ** 0.5), rel=0.01)
    assert max(rising) < 0.14
    assert abs(rising[-1]) < 1e-3
    assert abs(sim.budget.conservation()["energy"]) < 1e-9


def tipped(inertia, edge, end):
    """Angular velocity of a square of 2 m and 1 kg that slides without friction over an edge, this far from beneath its middle.

    With the place x of the middle from the edge and the angle a, the middle is at y = (1 - x sin a)/cos a above it.
    """

    def rates(_, state):
        x, angle, speed, spin = state
        c, s = np.cos(angle), np.sin(angle)
        along, about = -s / c, (s - x) / c**2
        growth = 2.0 * (-1.0 / c**2) * speed * spin + (c**2 + 2.0 * (s - x) * s) / c**3 * spin**2  # of the height by itself
        mass = np.array([[1.0 + along**2, along * about], [along * about, inertia + about**2]])
        return [speed, spin, *np.linalg.solve(mass, -(1.0 + growth) * np.array([along, about]))]

    return solve_ivp(rates, (0.0, end), [edge, 0.0, 0.0, 0.0], rtol=1e-9).y[3, -1]


@pytest.mark.parametrize("cell", [1.0, 0.5])
def test_a_block_on_one_edge_tips_over(cell):
    """A quarter of it lies on a step that a motion holds: it turns about the edge of the step."""
    step = box((0, 0, 0), (4, 3, 0), SOLID, (2, 2, 1), name="step", field="step")
    block = rigid((3.5, 3, 0), (5.5, 5, 0), field="block")
    hold = {"name": "hold", "body": "step", "hold": ["x", "y", "z"]}
    size = SIZE | {"counts": (round(8 / cell), round(8 / cell), 1), "cell": cell}
    sim = Simulation(case(step, block, motion=[hold], gravity=(0, -1.0, 0), end=2.0, step=5e-3, **size), threads=1)
    advance(sim, 200)
    arrays = sim.bodies[1].arrays
    across = (arrays["position"] - arrays["position"].mean(axis=0))[:, :2]
    squares = np.sum(across**2)
    spin = np.sum(across[:, 1] * arrays["velocity"][:, 0] - across[:, 0] * arrays["velocity"][:, 1]) / squares
    assert spin == pytest.approx(tipped(2.0 / 3.0, 0.5, sim.time), rel=0.02)


@pytest.mark.parametrize(("field", "share"), [("common", 1e-8), ("block", 1e-6)])
def test_a_rigid_block_settles_with_its_soil(field, share):
    """It sinks as the soil beneath is compressed, and stays there; where it touches soil of another field the gap opens and
    closes by what it falls in a step."""
    sim = Simulation(on_soil("trilinear", field, {"share": share, "most_steps": 2000}), threads=1)
    sim.settle()
    rest = sim.bodies[1].arrays["position"].copy()
    assert sunk(sim) < max(0.01, GIVES_WAY[field])
    assert 0.03 < 4.0 - rest[:, 1].mean() < 0.1, "with the soil"
    fastest = 0.0
    for _ in range(200):
        sim.step()
        fastest = max(fastest, sim.kinetic_energy())
    assert fastest < share * sim.budget.at_stake
    assert np.abs(sim.bodies[1].arrays["position"] - rest).max() < 2e-3
    assert abs(sim.budget.conservation()["energy"]) < 1e-4


@pytest.mark.parametrize("counts", [(10, 10, 10), (10, 10, 1)])
def test_a_rigid_body_keeps_its_shape_and_its_spin(counts):
    """Alone in space it turns with constant momentum and, about a principal axis, constant angular velocity."""
    depth = counts[2]
    upper = (6.0, 6.0, 6.0) if depth > 1 else (6.0, 6.0, 1.0)
    lower = (4.0, 4.0, 4.0) if depth > 1 else (4.0, 4.0, 0.0)
    block = box(lower, upper, RATE_SOLID, per_cell=(2, 2, 2 if depth > 1 else 1), velocity=(0.3, 0.2, 0.0))
    block |= {"angular_velocity": (0.0, 0.0, 2.0), "rigid": True}
    sim = Simulation(case(block, counts=counts, end=3.0), threads=1)
    body = sim.bodies[0]
    first = body.frame()["position"]
    while not sim.clock.finished(None):
        sim.step()
    last = body.frame()["position"]
    offset, turned = first - first.mean(axis=0), last - last.mean(axis=0)
    assert np.linalg.norm(turned[:, None] - turned, axis=2) == pytest.approx(
        np.linalg.norm(offset[:, None] - offset, axis=2), abs=1e-11
    )
    c, s = np.cos(6.0), np.sin(6.0)
    # FLIP keeps the points' own velocities; the grid's fields, which turn the body through the forces, are zero in it
    assert turned == pytest.approx(offset @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1.0]]), abs=1e-9)
    assert sim.budget.conservation()["momentum"] < 1e-12


def test_a_rigid_body_that_strikes_water_loses_what_the_water_gains():
    block = box((3, 4, 3), (5, 6, 5), RATE_SOLID | {"density": 4000.0}, velocity=(0.0, -1.0, 0.0)) | {"rigid": True}
    water = box((0, 0, 0), (8, 3.5, 8), WATER, name="water")
    few_cells = {"warn": 0.5, "stop": 0.5}  # so coarse a grid loses a quarter of the energy in the impact
    sim = Simulation(case(block, water, counts=(8, 8, 8), support=SLIP, end=2.0, energy=few_cells), threads=1)
    advance(sim, 150)
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert sim.bodies[0].totals.momentum[1] > -0.8 * 32000.0
    assert not sim.bodies[0].field("stress").any()


@pytest.mark.parametrize("transfer", ["pic", "blend", "apic"])
def test_a_rigid_body_keeps_its_spin_with_every_transfer(transfer):
    """In a velocity field of its own, beside a fluid in another."""
    block = rigid((3, 3, 0), (5, 5, 0), field="block", angular_velocity=(0, 0, 2.0), velocity=(0.2, 0, 0))
    water = box((0, 0, 0), (8, 1, 0), WATER, (2, 2, 1), name="water")
    sim = advance(Simulation(case(block, water, transfer=transfer, support=SLIP[:4], step=0.01, **SIZE), threads=1), 50)
    assert sim.bodies[0].constraint.rates() == pytest.approx((0.2, 0, 0, 0, 0, 2.0), abs=1e-9)
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert abs(sim.budget.energy_error()) < 1e-9


SHAPES = {
    "brick": ({"box": {"lower": (3.5, 2.5, 1.5), "upper": (4.5, 5.5, 6.5)}}, (0.05, 3.0, 0.0)),
    "askew": (
        {"box": {"lower": (2, 3, 3.5), "upper": (6, 5, 4.5)}, "rotate": {"axis": [1, 1, 0], "angle": 35}},
        (0.2, -2.0, 1),
    ),
}


@pytest.mark.parametrize("name", SHAPES)
def test_a_free_body_tumbles_by_eulers_equations(name):
    """About the axis of its middle inertia, in which it turns over, and about any other, with its default step. The equations
    are integrated to 1e-11 for the inertia of its points as cubes. Energy and angular momentum are constant."""
    shape, turn = SHAPES[name][0], np.array(SHAPES[name][1])
    body = {"name": "block", "shape": shape, "points_per_cell": (2, 2, 2), "material": SOLID, "rigid": True}
    sim = Simulation(case(body | {"angular_velocity": tuple(turn)}, counts=(8, 8, 8), end=4.0), threads=1)
    arrays, rigid = sim.bodies[0].arrays, sim.bodies[0].constraint
    m, own = arrays["mass"], np.sum(arrays["mass"] * arrays["volume"] ** (2.0 / 3.0)) / 6.0
    inertia = inertia_of(m[:, None], arrays["position"] - arrays["position"].mean(axis=0), own)
    if name == "brick":
        assert inertia == pytest.approx(np.diag(np.array([34.0, 26.0, 10.0]) * 15000.0 / 12.0), abs=1e-6), "that of the box"
    energy = sim.kinetic_energy()
    assert energy == pytest.approx(0.5 * turn @ inertia @ turn, rel=1e-12)

    def rates(_, w):
        return np.linalg.solve(inertia, np.cross(inertia @ w, w))

    while not sim.clock.finished(None):
        sim.step()
    exact = solve_ivp(rates, (0.0, sim.time), turn, rtol=1e-11, atol=1e-13).y[:, -1]
    assert np.sum(rigid.rates()[3:] ** 2) == pytest.approx(np.sum(exact**2), rel=1e-6)
    assert sim.kinetic_energy() == pytest.approx(energy, rel=1e-8)
    assert sim.budget.conservation()["angular_momentum"] < 1e-12
    assert abs(sim.budget.conservation()["energy"]) < 1e-8
