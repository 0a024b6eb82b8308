"""Points that follow a prescribed motion."""

import numpy as np
import pytest
from small_cases import GAS, RATE_SOLID, SLIP, advance, box, case

from pellucid.case import Case
from pellucid.errors import CaseError
from pellucid.simulation.simulation import Simulation

WATER = {
    "kind": "fluid",
    "density": 1000.0,
    "pressure": 0.0,
    "viscosity": 1e-3,
    "eos": {"kind": "stiffened-gas", "gruneisen": 4.0, "p_infinity": 2e4},
}
SWING = {
    "name": "swing",
    "body": "block",
    "hold": ["x"],
    "displacement": {"y": {"kind": "sine", "amplitude": 0.4, "period": 2.0}},
}
SCHEMES = ["musl", "usl", "usf"]


def driven(*bodies, motion, threads=1, **more):
    table = case(*bodies, **more).to_data() | {"motion": [motion] if isinstance(motion, dict) else list(motion)}
    return Simulation(Case.model_validate(table), threads=threads)


def tank(**more):
    """A block in water that fills a closed box."""
    water = {"outside": ["block"], **box((0, 0, 0), (8, 8, 8), WATER, name="water", per_cell=(2, 2, 2))}
    block = box((3, 3, 3), (5, 5, 5), RATE_SOLID)
    return (block, water), {"counts": (8, 8, 8), "support": SLIP, "end": 2.0} | more


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("functions", ["trilinear", "quadratic-bspline"])
def test_driven_points_follow_exactly_whatever_meets_them(scheme, functions):
    bodies, more = tank(scheme=scheme, functions=functions)
    sim = driven(*bodies, motion=SWING, **more)
    start = sim.bodies[0].frame()["position"]
    for _ in range(60):
        sim.step()
        moved = sim.bodies[0].frame()["position"] - start
        assert moved[:, 1] == pytest.approx(0.4 * np.sin(np.pi * sim.time), abs=1e-14)
        assert np.array_equal(moved[:, 0], np.zeros(len(moved)))
    assert sim.budget.conservation()["momentum"] < 1e-12
    assert np.abs(sim.bodies[1].field("velocity")).max() > 0.1, "the water is pushed"


@pytest.mark.parametrize("scheme", SCHEMES)
@pytest.mark.parametrize("transfer", ["flip", "apic"])
def test_the_reaction_is_the_change_of_momentum(scheme, transfer):
    """A free-flying block whose middle is driven: nothing else gives it momentum."""
    motion = {
        "name": "push",
        "body": "block",
        "part": {"box": {"lower": (2.0, 2.0, 2.0), "upper": (4.0, 3.0, 3.0)}},
        "displacement": {"x": {"kind": "steady", "velocity": 0.1}},
    }
    block = box((2, 2, 2), (4, 4, 4), RATE_SOLID, velocity=(0.0, 0.2, 0.0))
    sim = driven(block, motion=motion, counts=(8, 8, 8), scheme=scheme, transfer=transfer, end=20.0)
    before = sim.momentum()
    advance(sim, 12)
    gained = sim.momentum() - before
    assert gained[0] > 0.03 * sim.budget.momentum_scale
    assert sim.budget.reactions()["push"] == pytest.approx(gained, abs=1e-12 * sim.budget.momentum_scale)


def test_work_of_a_motion_on_a_body_alone_is_its_kinetic_energy():
    """A block that is driven as a whole is rigid: its energy is the work of the motion less what was lost in the first jerk."""
    motion = {"name": "go", "body": "block", "hold": ["x", "z"], "displacement": {"y": {"kind": "steady", "velocity": 0.5}}}
    sim = driven(box((2, 1, 2), (4, 3, 4), RATE_SOLID), motion=motion, counts=(6, 8, 6), end=20.0)
    assert not sim.bodies[0].constraint.strains
    advance(sim, 5)
    energies, mass = sim.budget.energies(), 8000.0
    assert energies["kinetic"] == pytest.approx(0.5 * mass * 0.25, rel=1e-12)
    # setting a body moving at once takes twice the energy that it then has
    assert energies["motion_work"] == pytest.approx(mass * 0.25, rel=1e-12)
    assert energies["impact_heat"] == pytest.approx(0.5 * mass * 0.25, rel=1e-12)
    assert sim.budget.energy_error() == pytest.approx(0.0, abs=1e-12)


def test_a_smooth_motion_loses_nothing_as_the_step_falls():
    """The loss is that of a jump of velocity in each step, so its sum is of first order in the step."""
    motion = {
        "name": "go",
        "body": "block",
        "hold": ["x", "z"],
        "displacement": {"y": {"kind": "ramp", "distance": 2.0, "duration": 1.0}},
    }
    lost = []
    for step in (0.01, 0.005):
        sim = driven(box((2, 1, 2), (4, 3, 4), RATE_SOLID), motion=motion, counts=(6, 8, 6), step=step)
        advance(sim, round(0.5 / step))
        lost.append(sim.budget.energies()["impact_heat"] / sim.budget.energies()["kinetic"])
    assert lost[0] < 0.05
    assert lost[0] / lost[1] == pytest.approx(2.0, abs=0.1)


def test_a_piston_compresses_gas_like_a_wall():
    """A driven block closes a tube slowly: the gas takes its work as p dV does on an adiabat."""
    ramp = {"kind": "ramp", "distance": 4.0, "duration": 120.0}
    motion = {"name": "piston", "body": "block", "hold": ["y", "z"], "displacement": {"x": ramp}}
    gas = box((4, 0, 0), (24, 1, 1), GAS, name="gas", per_cell=(4, 1, 1))
    block = box((2, 0, 0), (4, 1, 1), RATE_SOLID, per_cell=(4, 1, 1))
    more = {"functions": "quadratic-bspline", "support": [{"where": "x-upper", "fix": "normal"}], "end": 120.0}
    sim = driven(block, gas, motion=motion, counts=(24, 1, 1), **more)
    while not sim.clock.finished(None):
        sim.step()
    pressure = sim.bodies[1].field("pressure").mean()
    # seven passages of sound: what still swings is of the order of the piston's Mach number, 0.04, squared, and noise
    assert pressure == pytest.approx((20.0 / 16.0) ** 1.4, rel=0.01)
    energies = sim.budget.energies()
    assert energies["motion_work"] - energies["impact_heat"] == pytest.approx(50.0 * ((20.0 / 16.0) ** 0.4 - 1.0), rel=0.01)


def test_bits_do_not_depend_on_threads_and_a_checkpoint_goes_on():
    bodies, more = tank()
    one, two = (driven(*bodies, motion=SWING, threads=threads, **more) for threads in (1, 2))
    advance(one, 30)
    advance(two, 30)
    for first, second in zip(one.bodies, two.bodies, strict=True):
        assert all(np.array_equal(first.arrays[name], second.arrays[name]) for name in first.arrays)
    again = driven(*bodies, motion=SWING, **more)
    again.restore({name: array.copy() for name, array in one.state_arrays().items()}, one.state_numbers())
    advance(again, 20)
    advance(two, 20)
    assert np.array_equal(again.bodies[1].arrays["velocity"], two.bodies[1].arrays["velocity"])
    assert again.budget.reactions()["swing"].tolist() == two.budget.reactions()["swing"].tolist()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"body": "blok"}, "no body has this name; available names: block"),
        ({"hold": ["y"]}, "y is in both `hold` and `displacement`"),
        ({"hold": [], "displacement": {}}, "prescribes no direction"),
        ({"part": {"box": {"lower": (0, 0, 0), "upper": (1, 1, 1)}}}, "no point of body block lies in it at the start"),
    ],
)
def test_motions_that_make_no_sense(change, words):
    with pytest.raises((CaseError, ValueError), match=words):
        driven(box((3, 3, 3), (5, 5, 5), RATE_SOLID), motion=SWING | change, counts=(8, 8, 8))


@pytest.mark.parametrize("rigid", [False, True])
def test_no_body_is_led_out_of_a_plane(rigid):
    across = {"name": "across", "body": "block", "displacement": {"z": {"kind": "steady", "velocity": 1.0}}}
    words = r"motion.0.displacement.z: the grid is one cell thick along z: nothing moves along this axis"
    with pytest.raises(ValueError, match=words):
        driven(box((3, 3, 0), (5, 5, 0), RATE_SOLID, (2, 2, 1), rigid=rigid), motion=across, counts=(8, 8, 0))


def test_parts_of_a_body_cannot_follow_two_motions():
    with pytest.raises(CaseError, match="already follow the motion swing"):
        driven(box((3, 3, 3), (5, 5, 5), RATE_SOLID), motion=[SWING, SWING | {"name": "other"}], counts=(8, 8, 8))
