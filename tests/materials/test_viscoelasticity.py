"""The viscoelastic laws of users: creep, relaxation and what they dissipate, against the formulas of rheology."""

import numpy as np
import pytest
from samples import USERS

from pellucid.materials.law import stored_energy, update

SHEAR = (0.0, 1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # velocity gradient of a pure shear at the rate γ' = 2 [1/s]
STILL = (0.0,) * 9


def sheared(material, rates, dt):
    """The states after steps of pure shear at the given rates γ' [1/s]."""
    law, state, states = material.law(), material.initial_state(), []
    for rate in rates:
        L = tuple(0.5 * rate * component for component in SHEAR)
        state = update(law, state, material.density, L, dt, 0.01)
        states.append(state)
    return states


def shear_modulus(material):
    return material.young_modulus / (2.0 * (1.0 + material.poisson_ratio))


def test_a_kelvin_voigt_solid_adds_viscous_stress_while_it_moves():
    """τ = G γ + η γ', and what the dashpot takes is η γ'² of unit volume and time."""
    material, dt, rate = USERS["user-kelvin-voigt"], 1e-5, 0.1
    G, eta = shear_modulus(material), material.viscosity
    states = sheared(material, [rate] * 100 + [0.0], dt)
    for steps in (1, 100):
        expected = G * steps * dt * rate + eta * rate
        assert states[steps - 1].stress[5] == pytest.approx(expected, rel=1e-6)
    assert states[-1].stress[5] == pytest.approx(G * 100 * dt * rate, rel=1e-6)
    assert states[-1].viscous_work == pytest.approx(eta * rate**2 * 100 * dt / material.density, rel=1e-12)
    strain_energy = 0.5 * G * (100 * dt * rate) ** 2 / material.density
    found = stored_energy(material.law(), states[-1], material.density)
    # at a strain of 1e-4, W is a difference of numbers near 1
    assert found == pytest.approx(strain_energy + states[-1].viscous_work, rel=1e-6)


@pytest.mark.parametrize("steps", [10, 1000])
def test_a_standard_linear_solid_relaxes(steps):
    """After a sudden shear γ the stress falls as G γ + μ₁ γ exp(-t/τ), exactly at any step."""
    material, strain = USERS["standard-linear"], 1e-4
    G, branch, tau, sudden = shear_modulus(material), material.branch_modulus, material.relaxation_time, 1e-9
    law = material.law()
    L = tuple(0.5 * strain / sudden * component for component in SHEAR)
    state, dt = update(law, material.initial_state(), material.density, L, sudden, 0.01), 2.0 * tau / steps
    assert state.stress[5] == pytest.approx((G + branch) * strain, rel=1e-8)
    for _ in range(steps):
        state = update(law, state, material.density, STILL, dt, 0.01)
    assert state.stress[5] == pytest.approx(G * strain + branch * strain * np.exp(-2.0), rel=1e-8)
    assert state.overstress[5] == pytest.approx(branch * strain * np.exp(-2.0), rel=1e-8)


def test_a_standard_linear_solid_in_steady_oscillation():
    """Storage and loss modulus: G' = G + μ₁ ω²τ²/(1+ω²τ²), G'' = μ₁ ωτ/(1+ω²τ²); a cycle takes π G'' γ₀²."""
    material, amplitude, steps, cycles = USERS["standard-linear"], 1e-4, 2000, 6
    G, branch, tau = shear_modulus(material), material.branch_modulus, material.relaxation_time
    omega = 1.0 / tau  # where the loss is greatest
    dt = 2.0 * np.pi / omega / steps
    time = dt * np.arange(cycles * steps + 1)
    strain = amplitude * np.sin(omega * time)
    states = sheared(material, np.diff(strain) / dt, dt)
    last = np.array([state.stress[5] for state in states[-steps:]])
    phase = omega * time[-steps:]
    storage, loss = 2.0 / steps * last @ np.sin(phase), 2.0 / steps * last @ np.cos(phase)
    # strain follows its sine by chords, 1e-6, and what the start left has faded by exp(-2π) a cycle
    assert storage == pytest.approx((G + 0.5 * branch) * amplitude, rel=1e-5)
    assert loss == pytest.approx(0.5 * branch * amplitude, rel=1e-4)
    energy = [stored_energy(material.law(), state, material.density) for state in (states[-steps - 1], states[-1])]
    assert energy[1] - energy[0] == pytest.approx(np.pi * 0.5 * branch * amplitude**2 / material.density, rel=1e-4)
