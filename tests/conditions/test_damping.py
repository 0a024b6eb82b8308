"""Damping of a body: decay of a free body and of a swing, and the ledger."""

import numpy as np
import pytest
from elements import element_sheet
from membranes import sheet
from small_cases import GAS, RATE_SOLID, SLIP, advance, box, case, simulation

from pellucid.bodies.damped_model import DampedModel

RATE, STEP = 3.0, 1e-3
BODIES = {
    "solid": box((2, 2, 2), (4, 4, 4), RATE_SOLID),
    "gas": box((2, 2, 2), (4, 4, 4), GAS | {"pressure": 0.0, "density": 1.0}),
    "membrane points": sheet(points=(7, 7)),
    "membrane elements": element_sheet(points=(4, 4)),
}


def moving(kind, **more):
    """A free body at 1 m/s."""
    settings = {"counts": (6, 6, 6), "step": STEP, "lower": (-3, -3, -3) if "membrane" in kind else (0, 0, 0)}
    return simulation(BODIES[kind] | {"velocity": (1.0, 0.0, 0.0), "damping": RATE} | more.pop("body", {}), **(settings | more))


def mean_velocity(sim):
    body = sim.bodies[0].arrays
    return float(body["mass"] @ body["velocity"][:, 0] / body["mass"].sum())


@pytest.mark.parametrize("transfer", ["flip", "apic"])
@pytest.mark.parametrize("kind", ["solid", "gas", "membrane points"])
def test_a_free_body_on_the_grid_fades_exactly(kind, transfer):
    sim = advance(moving(kind, transfer=transfer), 200)
    assert mean_velocity(sim) == pytest.approx(np.exp(-RATE * 0.2), rel=1e-9)
    mass = sim.bodies[0].mass
    assert sim.budget.energies()["damping_heat"] == pytest.approx(0.5 * mass * (1.0 - np.exp(-2 * RATE * 0.2)), rel=1e-6)
    assert abs(sim.budget.conservation()["energy"]) < 1e-9
    assert abs(sim.budget.conservation()["momentum"]) < 1e-12


def test_nodes_of_their_own_fade_at_second_order():
    sim = advance(moving("membrane elements", step=5e-4), 400)
    # the drag of the mean velocity is wrong by (c Δt)²/12 of c t
    assert mean_velocity(sim) == pytest.approx(np.exp(-RATE * 0.2), rel=(RATE * 5e-4) ** 2)
    assert sim.budget.energies()["damping_heat"] > 0.0
    assert abs(sim.budget.conservation()["energy"]) < 1e-9


def test_it_ends_at_its_time():
    sim = advance(moving("solid", body={"damping_until": 0.1005}), 300)
    assert mean_velocity(sim) == pytest.approx(np.exp(-RATE * 0.1005), rel=1e-9)


def test_a_swing_fades_as_an_oscillator_and_the_ledger_tells_where_it_went():
    """A bar between walls in its first standing wave, q'' + c q' + ω² q = 0 from q = 0."""
    wave = {"amplitude": (1e-3, 0.0, 0.0), "wave_vector": (np.pi / 8, 0.0, 0.0)}
    stiff = RATE_SOLID | {"poisson_ratio": 0.0}
    bar = box((0, 0, 0), (8, 1, 0), stiff, (4, 1, 1), velocity_wave=wave, damping=0.5)
    sim = simulation(bar, counts=(8, 1, 1), functions="quadratic-bspline", support=SLIP[:4], end=1e3)
    start, frequency = sim.kinetic_energy(), np.pi / 8 * np.sqrt(1e4 / 1e3)
    while sim.time < 5.0:
        sim.step()
    faded, turn = np.exp(-0.25 * sim.time), np.sqrt(frequency**2 - 0.25**2)
    place = faded * frequency / turn * np.sin(turn * sim.time)
    speed = faded * (np.cos(turn * sim.time) - 0.25 / turn * np.sin(turn * sim.time))
    balance = sim.budget.energies()
    left = balance["kinetic"] + balance["strain"]
    # eight cells: the frequency is right to 1 %, the splitting of drag and motion to half a step
    assert left / start == pytest.approx(place**2 + speed**2, rel=0.02)
    assert balance["damping_heat"] == pytest.approx(start - left - balance["staggering"], rel=1e-4)
    assert abs(sim.budget.conservation()["energy"]) < 1e-4


@pytest.mark.parametrize("scheme", ["musl", "usf"])
def test_the_drag_on_a_membrane_within_a_gas_is_booked_in_full(scheme):
    """It slows the nodes of both by less than the points of the membrane, whose tension works along the nodes."""
    net = sheet(edges=((0, 4, 0), (0, 0, 1)), points=(13, 4), thickness=0.1, tension=0.5, damping=500.0)
    net["surface"]["rectangle"]["corner"] = (2, 0, 0)
    net["material"] |= {"density": 2.0, "young_modulus": 50.0}
    stir = {"amplitude": (0.3, 0.2, 0.0), "wave_vector": (2.0, 1.0, 0.0)}
    sides = [
        box((x, 0, 0), (x + 2, 4, 1), GAS | {"pressure": p}, (2, 2, 1), name=name, velocity_wave=stir)
        for x, p, name in ((0, 1.5, "hot"), (2, 1.0, "cold"))
    ]
    how = {"functions": "quadratic-bspline", "support": SLIP[:4], "scheme": scheme, "courant": 0.1, "end": 1e3}
    sim = advance(simulation(*sides, net, counts=(4, 4, 1), **how), 160)
    balance, scale = sim.budget.energies(), sim.budget.energy_scale
    assert balance["damping_heat"] > 1e-3 * scale
    assert abs(balance["transfer_error"]) < 1e-12 * scale
    # 2e-4 without a drag; 3e-3 where the change of f·v Δt/2 is taken from the velocities of the membrane's points alone
    assert abs(sim.budget.energy_error()) < 6e-4


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"damping_until": 1.0}, "has no effect without `damping`"),
        ({"damping": -1.0}, "greater than or equal to 0"),
        ({"damping": 1.0, "rigid": True}, "is rigid: a drag on its points has no effect"),
    ],
)
def test_what_makes_no_sense_is_refused(keys, message):
    with pytest.raises(ValueError, match=message):
        case(BODIES["solid"] | keys)


def test_bodies_with_inertia_have_it():
    assert all(isinstance(case(body, lower=(-3, -3, -3), counts=(8, 8, 8)).body[0], DampedModel) for body in BODIES.values())
