"""Forces, torques and springs on rigid bodies against exact answers."""

import json

import numpy as np
import pytest
from small_cases import RATE_SOLID, advance, box, case

from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

PLANE, SPACE = (8, 8, 1), (8, 8, 8)
FEW = {"warn": 0.5, "stop": 10.0}


def disc(**more):
    """Of radius 1.5 m, in the plane."""
    shape = {"cylinder": {"centre": (4, 4, 0), "radius": 1.5, "axis": "z", "height": 1.0}}
    return {"name": "disc", "shape": shape, "points_per_cell": (3, 3, 1), "material": RATE_SOLID, "rigid": True} | more


def cube(**more):
    """Of 2 m edges."""
    return box((3, 3, 3), (5, 5, 5), RATE_SOLID, (2, 2, 2), name="disc", rigid=True, **more)


def loaded(body, *load, motion=(), counts=PLANE, threads=1, **more):
    tables = {"load": [{"body": "disc"} | one for one in load], "motion": [{"body": "disc"} | one for one in motion]}
    return Simulation(case(body, counts=counts, energy=FEW, **tables, **({"end": 20.0, "step": 0.01} | more)), threads=threads)


def inertia(body):
    """About z through the centre of mass [kg m²]."""
    m, x = body.arrays["mass"], body.arrays["position"]
    r = x - np.average(x, axis=0, weights=m)
    squares = body.arrays["volume"] ** (2.0 / 3.0 if np.ptp(x[:, 2]) > 0.0 else 1.0)  # of the edges of cubes, or of squares
    return float(np.sum(m * (r[:, 0] ** 2 + r[:, 1] ** 2 + squares / 6.0)))


def angle(sim):
    return sim.bodies[0].arrays["angle"][0]


def centre(sim):
    body = sim.bodies[0]
    return np.average(body.arrays["position"], axis=0, weights=body.arrays["mass"])


def closes(sim, share=1e-9):
    errors = sim.budget.conservation()
    assert errors["momentum"] < 1e-12
    assert abs(errors["energy"]) < share


@pytest.mark.parametrize("scheme", ["musl", "usl", "usf"])
@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_a_torque_turns_a_disc(scheme, functions):
    """θ = T t²/2I, in steps T t (t + Δt)/2I; its work is the energy of the disc."""
    sim = loaded(disc(), {"kind": "rigid-force", "torque": (0, 0, 5000.0)}, scheme=scheme, functions=functions)
    body = sim.bodies[0]
    assert inertia(body) == pytest.approx(0.5 * body.mass * 1.5**2, rel=0.03), "that of a disc"
    first, rate = centre(sim), 5000.0 / inertia(body)
    advance(sim, 100)
    assert angle(sim) == pytest.approx((0.0, 0.0, 0.5 * rate * 1.01), rel=1e-9)
    assert centre(sim) == pytest.approx(first, abs=1e-10)
    energies = sim.budget.energies()
    assert energies["kinetic"] == pytest.approx(0.5 * inertia(body) * rate**2, rel=1e-9)
    assert energies["load_work"] == pytest.approx(energies["kinetic"], rel=0.02)
    closes(sim, 3e-3 if scheme == "usf" else 1e-7)  # of first order in the step with USF


def test_a_force_acts_at_the_centre_and_changes_in_time():
    """x'' = F/m of a share that rises linearly: v = F t²/2m; the disc does not turn."""
    force = {"kind": "rigid-force", "force": (700.0, 0, 0), "amplitude": {"times": [0, 1], "shares": [0, 1]}}
    sim = loaded(disc(), force)
    advance(sim, 100)
    mass = sim.bodies[0].mass
    assert sim.momentum()[0] == pytest.approx(700.0 * 0.5 * 0.99, rel=1e-9)
    assert angle(sim) == pytest.approx(np.zeros(3), abs=1e-12)
    assert sim.budget.energies()["load_work"] == pytest.approx(0.5 * sim.momentum()[0] ** 2 / mass, rel=1e-9)
    closes(sim)


def test_a_torsion_pendulum_swings_with_its_period():
    """T = 2π sqrt(I/k), of second order in the step; in a swing the spring's work comes to nothing."""
    spring = {"kind": "rigid-spring", "turning_stiffness": (0, 0, 4000.0)}
    errors = []
    for step in (0.04, 0.02):
        sim = loaded(disc(angular_velocity=(0, 0, 0.5)), spring, step=step)
        period = 2.0 * np.pi * np.sqrt(inertia(sim.bodies[0]) / 4000.0)
        angles, most = [angle(sim)[2]], 0.0
        while sim.time < 2.2 * period:
            sim.step()
            angles.append(angle(sim)[2])
            most = max(most, abs(sim.budget.energies()["spring_work"]))
        up = [n for n in range(1, len(angles) - 1) if angles[n] <= 0.0 < angles[n + 1]]
        crossing = up[0] - angles[up[0]] / (angles[up[0] + 1] - angles[up[0]])
        second = up[1] - angles[up[1]] / (angles[up[1] + 1] - angles[up[1]])
        errors.append(abs((second - crossing) * step / period - 1.0))
        assert max(angles) == pytest.approx(0.5 * period / (2.0 * np.pi), rel=1e-3)
        energy = 0.5 * inertia(sim.bodies[0]) * 0.25
        assert most == pytest.approx(energy, rel=0.01)
        closes(sim, 1e-6)
    assert errors[1] < 1e-4
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.8)


def test_a_damper_takes_what_a_swing_has():
    """x = v e^(-c t/2m) sin(ω t)/ω with ω² = k/m - (c/2m)²; in the end all energy is heat."""
    spring = {"kind": "rigid-spring", "stiffness": (3000.0, 3000.0, 0), "damping": (8000.0, 8000.0, 0)}
    sim = loaded(disc(velocity=(0.4, 0.1, 0.0)), spring, step=0.005)
    first, start = centre(sim), sim.kinetic_energy()
    mass = sim.bodies[0].mass
    decay, swing = 8000.0 / (2.0 * mass), np.sqrt(3000.0 / mass - (8000.0 / (2.0 * mass)) ** 2)
    advance(sim, 200)
    t = sim.time
    exact = np.array([0.4, 0.1, 0.0]) / swing * np.exp(-decay * t) * np.sin(swing * t)
    assert centre(sim) - first == pytest.approx(exact, rel=0.01)
    while sim.time < 8.0 / decay:
        sim.step()
    energies = sim.budget.energies()
    assert energies["damping_heat"] == pytest.approx(start, rel=1e-3)
    assert abs(energies["spring_work"]) < 1e-3 * start
    closes(sim)


def test_a_moving_anchor_draws_the_body_along():
    """Of an anchor of steady velocity v: x = v t - v sin(ω t)/ω. The spring does the work of the anchor."""
    spring = {"kind": "rigid-spring", "stiffness": (20000.0, 0, 0), "anchor": {"x": {"kind": "steady", "velocity": 0.3}}}
    sim = loaded(disc(), spring, step=0.005)
    first, omega = centre(sim), np.sqrt(20000.0 / sim.bodies[0].mass)
    advance(sim, 300)
    t = sim.time
    assert (centre(sim) - first)[0] == pytest.approx(0.3 * t - 0.3 * np.sin(omega * t) / omega, abs=2e-3)
    assert sim.budget.energies()["spring_work"] == pytest.approx(sim.kinetic_energy(), rel=1e-9)
    closes(sim)


def test_a_moving_anchor_of_a_damper_carries_the_body():
    """v = u (1 - e^(-c t/I)) of a disc in a bearing that turns with u: half of what the bearing gives becomes heat."""
    drag = {"kind": "rigid-spring", "turning_damping": (0, 0, 9000.0)}
    drag["anchor_rotation"] = {"z": {"kind": "steady", "angular_velocity": 2.0}}
    sim = loaded(disc(), drag, step=0.005)
    at = 9000.0 / inertia(sim.bodies[0])
    advance(sim, 100)
    spin = sim.bodies[0].constraint.rates()[5]
    assert spin == pytest.approx(2.0 * (1.0 - np.exp(-at * sim.time)), rel=0.005)
    while at * sim.time < 12.0:
        sim.step()
    energy, energies = 0.5 * inertia(sim.bodies[0]) * 4.0, sim.budget.energies()
    assert energies["kinetic"] == pytest.approx(energy, rel=1e-4)
    assert energies["spring_work"] == pytest.approx(2.0 * energy, rel=1e-3)
    # what goes between points and nodes takes its share of the first steps
    assert energies["damping_heat"] + energies["transfer_heat"] == pytest.approx(energy, rel=0.01)
    closes(sim, 1e-6)


def test_in_space_a_spring_about_two_axes_is_two_pendulums_at_small_angles():
    """Of a cube, whose inertia is the same about all axes, with a stiffness of its own about each."""
    spring = {"kind": "rigid-spring", "turning_stiffness": (20000.0, 45000.0, 0), "stiffness": (0, 0, 30000.0)}
    start = cube(angular_velocity=(0.02, 0.03, 0.0), velocity=(0.0, 0.0, 0.1))
    sim = loaded(start, spring, counts=SPACE, step=0.01)
    first, moment, mass = centre(sim), inertia(sim.bodies[0]), sim.bodies[0].mass
    advance(sim, 100)
    t = sim.time
    about = [rate * np.sin(w * t) / w for rate, w in ((0.02, np.sqrt(20000.0 / moment)), (0.03, np.sqrt(45000.0 / moment)))]
    assert angle(sim)[:2] == pytest.approx(about, rel=0.01)
    w = np.sqrt(30000.0 / mass)
    assert (centre(sim) - first)[2] == pytest.approx(0.1 * np.sin(w * t) / w, rel=0.01)
    closes(sim, 1e-6)


def test_a_load_on_what_a_motion_leads_is_borne_by_the_motion():
    """A torque on a body whose rotation is held does no work: the motion has it."""
    sim = loaded(
        disc(),
        {"kind": "rigid-force", "torque": (0, 0, 5000.0), "force": (0.0, 300.0, 0.0)},
        motion=[{"name": "hold", "hold": ["x", "y"], "hold_rotation": ["z"]}],
    )
    first = centre(sim)
    advance(sim, 100)
    assert sim.budget.angular_reactions()["hold"] == pytest.approx((0.0, 0.0, -5000.0), abs=1e-6)
    assert sim.budget.reactions()["hold"] == pytest.approx((0.0, -300.0, 0.0), abs=1e-8)
    assert centre(sim) == pytest.approx(first, abs=1e-13)
    assert sim.budget.energies()["load_work"] == pytest.approx(0.0, abs=1e-9)
    closes(sim)


def test_a_spring_bounds_the_step():
    stiff = {"kind": "rigid-spring", "turning_stiffness": (0, 0, 1e8)}
    sim = loaded(disc(), stiff, step=None)
    advance(sim, 3)
    assert sim.dt == pytest.approx(0.4 * np.sqrt(inertia(sim.bodies[0]) / 1e8), rel=1e-6)
    with pytest.raises(CaseError, match="stable step"):
        loaded(disc(), stiff)


def test_bits_do_not_depend_on_threads_and_a_checkpoint_goes_on():
    loads = (
        {"kind": "rigid-spring", "turning_stiffness": (9e3, 2e4, 4e3), "stiffness": (3e3, 0, 0), "damping": (0, 200.0, 0)},
        {"kind": "rigid-force", "torque": (30.0, 0, 200.0), "rise": 0.3},
    )
    start = cube(angular_velocity=(0.3, 0.1, 0.2), velocity=(0.1, 0.1, 0))
    one, two = (loaded(start, *loads, counts=SPACE, threads=threads) for threads in (1, 2))
    advance(one, 30)
    advance(two, 30)
    again = loaded(start, *loads, counts=SPACE)
    numbers = json.loads(json.dumps(one.state_numbers()))
    again.restore({name: array.copy() for name, array in one.state_arrays().items()}, numbers)
    advance(again, 20)
    advance(two, 20)
    for name, array in again.bodies[0].arrays.items():
        assert np.array_equal(array, two.bodies[0].arrays[name])
    assert again.budget.energies() == two.budget.energies()


TURNING = {"kind": "steady", "angular_velocity": 1}


@pytest.mark.parametrize(
    ("load", "words"),
    [
        ({"kind": "rigid-force"}, "this load has no effect; give a `force`, a `torque`, or both"),
        ({"kind": "rigid-force", "torque": (1, 0, 0)}, "bodies rotate about z only, not about x"),
        ({"kind": "rigid-force", "force": (0, 0, 1)}, "one cell thick along z: nothing moves along this axis"),
        ({"kind": "rigid-force", "torque": ["1 N", 0, 0]}, r"\(N\*m\) is required"),
        ({"kind": "rigid-spring"}, "this spring has no effect"),
        ({"kind": "rigid-spring", "stiffness": (-1, 0, 0)}, "stiffness has -1, but cannot be negative; use 0 or more"),
        (
            {
                "kind": "rigid-spring",
                "stiffness": (1, 0, 0),
                "anchor_rotation": {"x": {"kind": "steady", "angular_velocity": 1}},
            },
            "anchor_rotation: the grid is one cell thick along z: bodies rotate about z only, not about x",
        ),
        (
            {"kind": "rigid-spring", "stiffness": (1, 0, 0), "anchor": {"z": {"kind": "steady", "velocity": 1}}},
            "anchor: the grid is one cell thick along z: nothing moves along this axis",
        ),
        ({"kind": "rigid-spring", "turning_damping": (0, 1, 0)}, "bodies rotate about z only, not about y"),
    ],
)
def test_loads_that_make_no_sense(load, words):
    with pytest.raises((CaseError, ValueError), match=words):
        loaded(disc(), load)


@pytest.mark.parametrize(
    "kind", [{"kind": "rigid-force", "force": (1, 0, 0)}, {"kind": "rigid-spring", "stiffness": (1, 0, 0)}]
)
def test_only_a_rigid_body_is_loaded_as_a_whole(kind):
    with pytest.raises((CaseError, ValueError), match=r"body disc is not rigid: a rigid-\w+ acts on rigid bodies only"):
        loaded(disc(rigid=False), kind)
