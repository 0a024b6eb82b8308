"""The energy equation of fluids: closed, iterated, explicit; the work of the artificial viscosity."""

import numpy as np
import pytest
from algebra import matrix, tensor
from samples import INVISCID, RATES, fluid

from pellucid.materials.law import artificial_heating, signal_speed, stored_energy, update
from pellucid.tensors import double_dot, symmetric_part

CELL, DT = 0.01, 1e-3
SHOCKED = {"quadratic": 2.0, "linear": 1.0}
every_rate = pytest.mark.parametrize("rate", RATES.values(), ids=RATES)
every_eos = pytest.mark.parametrize("eos", INVISCID)


def stepped(material, L, before=None):
    """A point before and after a step: state, state, density at the end. Where `before` is given, a second step."""
    law, state, density = material.law(), material.initial_state(), material.density
    if before is not None:
        density /= 1.0 + DT * np.trace(matrix(before))
        state = update(law, state, density, before, DT, CELL)
    density /= 1.0 + DT * np.trace(matrix(L))
    return state, update(law, state, density, L, DT, CELL), density


def work(stress, L, density):
    return DT / density * double_dot(stress, symmetric_part(L))


@every_eos
@every_rate
@pytest.mark.parametrize("mode", ["closed", "iterated"])
def test_backward_euler_holds(eos, rate, mode):
    """e = e_k + dt/ρ σ:D with the stress that the update returns, viscosity and q included."""
    material = fluid(eos, viscosity=3.0, artificial_viscosity=SHOCKED, energy_update=mode)
    old, new, density = stepped(material, rate, before=RATES["general"])
    residual = new.internal_energy - old.internal_energy - work(new.stress, rate, density)
    # a stiff liquid's pressure is a small difference: rounding of (Γ+1) P∞ dt/ρ tr D = 1e-16 * 1e9 / 1e3 * 0.1
    scale = abs(new.internal_energy) + abs(old.internal_energy)
    assert abs(residual) < 1e-12 * scale


@every_eos
@every_rate
def test_closed_and_iterated_agree(eos, rate):
    found = {}
    for mode in ("closed", "iterated"):
        material = fluid(eos, viscosity=3.0, artificial_viscosity=SHOCKED, energy_update=mode)
        found[mode] = stepped(material, rate, before=RATES["general"])[1]
    # ten times the tolerance of the iteration
    assert found["iterated"].internal_energy == pytest.approx(found["closed"].internal_energy, rel=1e-11)
    scale = material.density * 1e6 if eos != "ideal-gas" else material.pressure
    assert found["iterated"].stress == pytest.approx(found["closed"].stress, abs=1e-11 * scale)


@every_eos
@pytest.mark.parametrize("name", ["squeeze", "swell"])
def test_explicit_takes_the_old_stress(eos, name):
    """York's order; where q does no work, the old stress without its q."""
    rate, before = RATES[name], RATES["squeeze"]
    material = fluid(eos, artificial_viscosity=SHOCKED, energy_update="explicit")
    old, new, density = stepped(material, rate, before)
    assert new.internal_energy == pytest.approx(old.internal_energy + work(old.stress, rate, density), rel=1e-13)
    closed = stepped(fluid(eos, artificial_viscosity=SHOCKED), rate, before)[1]
    assert abs(closed.internal_energy - new.internal_energy) > 1e-6 * abs(closed.internal_energy)


@every_eos
@pytest.mark.parametrize("mode", ["closed", "iterated", "explicit"])
def test_the_work_of_q_heats(eos, mode):
    """Over two steps the explicit update, which takes the old stress, has got the heat of the first one only."""
    rate = tuple(0.05 * r for r in RATES["squeeze"])
    found, heating = {}, {}
    for does_work in (True, False):
        material = fluid(eos, artificial_viscosity=SHOCKED | {"work": does_work}, energy_update=mode)
        old, found[does_work], density = stepped(material, rate, before=rate)
        heating[does_work] = artificial_heating(material.law(), old, density, rate, CELL)
    assert heating[True] > 0.0
    assert heating[False] == 0.0
    gained = found[True].internal_energy - found[False].internal_energy
    steps = 1.0 if mode == "explicit" else 2.0
    # density and sound speed change by the strain of the steps, 1 %, times Γ = 4
    assert gained == pytest.approx(steps * DT * heating[True], rel=0.05)


@pytest.mark.parametrize(("mode", "order"), [("closed", 1), ("explicit", 1), ("midpoint", 2)])
def test_isentropic_compression_is_followed_to_the_order_of_the_update(mode, order):
    """P ρ^-γ = const: the error falls with the step, and with its square for the mean of old and new stress."""
    material = fluid("ideal-gas", energy_update=mode)
    law = material.law()
    errors = []
    for steps in (100, 200):
        state, density, dt = material.initial_state(), material.density, 1.0 / steps
        while density < 2.0 * material.density:
            density /= 1.0 - dt
            state = update(law, state, density, tensor(np.diag([-1.0, 0.0, 0.0])), dt, CELL)
        exact = material.pressure * (density / material.density) ** 1.4
        errors.append(abs(-state.stress[0] / exact - 1.0))
    assert errors[0] < {"closed": 2e-3, "explicit": 6e-3, "midpoint": 2e-5}[mode]
    assert np.log2(errors[0] / errors[1]) == pytest.approx(order, abs=0.1)


@pytest.mark.parametrize(("mode", "sign"), [("closed", 1.0), ("explicit", -1.0), ("midpoint", 0.0)])
def test_a_wave_heats_or_cools_as_its_update_says(mode, sign):
    """A liquid swings: backward Euler adds dt²/2 K (tr D)² a step, forward Euler takes it, the mean does neither."""
    material = fluid("stiffened-gas", energy_update=mode)
    law, state, density, steps, amplitude = material.law(), material.initial_state(), material.density, 60, 1e-4
    dt = 1.0 / steps
    modulus = density * signal_speed(law, state, density, (0.0,) * 9, CELL) ** 2
    energy, false_heat = state.internal_energy, 0.0
    for step in range(steps):
        rate = 2.0 * np.pi * amplitude * np.cos(2.0 * np.pi * (step + 0.5) / steps)
        density /= 1.0 + dt * rate
        state = update(law, state, density, tensor(np.diag([rate, 0.0, 0.0])), dt, CELL)
        false_heat += 0.5 * dt**2 * modulus * rate**2 / density
    # what is left is of higher order in the amplitude
    assert state.internal_energy - energy == pytest.approx(sign * false_heat, abs=0.01 * false_heat)


def test_gan_s_numbers():
    """Cytoplasm and medium at P = 0: Γ = 4 with P∞ = 2.12e8 and 6.13e8 Pa; five digits, worked out by hand."""
    for p_infinity, energy, speed in ((2.12e8, 2.65e5, 1029.6), (6.13e8, 7.6625e5, 1750.7)):
        material = fluid("stiffened-gas", eos_changes={"p_infinity": p_infinity})
        state = material.initial_state()
        assert state.internal_energy == pytest.approx(energy, rel=1e-12)
        assert signal_speed(material.law(), state, 1000.0, (0.0,) * 9, CELL) == pytest.approx(speed, abs=0.05)


@every_eos
def test_the_initial_pressure_is_the_given_one(eos):
    material = INVISCID[eos]
    state = material.initial_state()
    after = update(material.law(), state, material.density, (0.0,) * 9, 0.0, CELL)
    # the rounding of (Γ+1) P∞ = 1e9 Pa
    assert after.stress == pytest.approx([-material.pressure] * 3 + [0.0] * 3, abs=1e-6)
    assert stored_energy(material.law(), state, material.density) == state.internal_energy


@pytest.mark.parametrize("eos", ["mie-gruneisen", "tait"])
@pytest.mark.parametrize("mode", ["closed", "iterated", "explicit", "midpoint"])
def test_a_liquid_that_carries_no_tension_pulls_apart(eos, mode):
    material = fluid(eos, eos_changes={"carries_tension": False}, energy_update=mode)
    pulling = fluid(eos, energy_update=mode)
    loose = stepped(material, RATES["swell"], before=RATES["swell"])[1]
    tied = stepped(pulling, RATES["swell"], before=RATES["swell"])[1]
    assert loose.stress == (0.0,) * 6
    assert tied.stress[0] > 1e6
    if mode in ("closed", "iterated"):  # no pressure, no work; only the way from the initial pressure down to zero
        start = material.initial_state().internal_energy
        assert loose.internal_energy == pytest.approx(start, abs=2.0 * DT * 100.0 * material.pressure / material.density)


@pytest.mark.parametrize("mode", ["closed", "iterated"])
@pytest.mark.parametrize("eos", ["ideal-gas", "stiffened-gas"])
def test_more_compression_than_the_equation_can_follow_is_no_number(eos, mode):
    """1 + Γ dt tr D ≤ 0: backward Euler has no sensible root, and the kernel's guard stops the run on nan."""
    changes = {"gamma": 4.0} if eos == "ideal-gas" else {}
    material = fluid(eos, eos_changes=changes, energy_update=mode)
    crush = tensor(np.diag([-0.6 / DT, 0.0, 0.0]))
    assert np.isnan(stepped(material, crush)[1].internal_energy)


@pytest.mark.parametrize(
    ("eos", "pressure", "changes"),
    [
        ("tait", -5.0, {"carries_tension": False}),
        ("mie-gruneisen", -5.0, {"carries_tension": False}),
        ("mie-gruneisen", 1e5, {"gruneisen": 0.0}),
    ],
)
def test_a_pressure_that_the_equation_of_state_cannot_have_is_an_error(eos, pressure, changes):
    with pytest.raises(ValueError, match="use pressure = 0"):
        fluid(eos, pressure=pressure, eos_changes=changes)
