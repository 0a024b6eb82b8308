"""The similarity solution of strong explosions."""

import numpy as np
import pytest

from pellucid.case import load
from pellucid.references.gas_dynamics import Blast, similarity


@pytest.mark.parametrize(("dimensions", "alpha"), [(1, 1.077), (2, 0.984), (3, 0.851)])
def test_energy_of_published_solutions(dimensions, alpha):
    """Sedov (1959), chapter IV, for γ = 1.4; the plane one on both sides."""
    assert similarity(dimensions, 1.4).alpha == pytest.approx(alpha, abs=6e-4)


@pytest.mark.parametrize("dimensions", [1, 2, 3])
def test_mass_behind_the_shock_is_what_it_swept(dimensions):
    found = similarity(dimensions, 1.4)
    mass = np.trapezoid(found.density * found.xi ** (dimensions - 1), found.xi)
    assert mass == pytest.approx(1.0 / dimensions, rel=1e-6)


@pytest.mark.parametrize("dimensions", [1, 2, 3])
def test_first_integral_of_energy(dimensions):
    """What is within ξ keeps its energy, so that p/ρ is an algebraic function of u and ξ (Sedov, chapter IV, section 11)."""
    found, gamma = similarity(dimensions, 1.4), 1.4
    xi, u = found.xi[2000:], found.velocity[2000:]  # further inside both γ u - ξ and ξ - u are small
    exact = 0.5 * (gamma - 1.0) * u**2 * (xi - u) / (gamma * u - xi)
    near = xi > 0.6
    assert found.pressure[2000:][near] / found.density[2000:][near] == pytest.approx(exact[near], rel=1e-6)


def test_satisfies_the_balances_in_space_and_time():
    blast, t, h = Blast(3, 1.0, 1.3, 1.4), 0.3, 1e-4
    r = float(blast.radius(t)) * np.linspace(0.5, 0.95, 10)
    before, after = blast.at(r, t - h), blast.at(r, t + h)
    inner, outer, here = blast.at(r - h, t), blast.at(r + h, t), blast.at(r, t)
    rate = {name: (after[name] - before[name]) / (2 * h) for name in here}
    slope = {name: (outer[name] - inner[name]) / (2 * h) for name in here}
    density, velocity, pressure = here["density"], here["velocity"], here["pressure"]
    divergence = slope["velocity"] + 2 * velocity / r
    mass = rate["density"] + velocity * slope["density"] + density * divergence
    assert np.abs(mass).max() < 1e-3 * np.abs(density * divergence).max()
    momentum = density * (rate["velocity"] + velocity * slope["velocity"]) + slope["pressure"]
    assert np.abs(momentum).max() < 1e-3 * np.abs(slope["pressure"]).max()
    heat = rate["pressure"] + velocity * slope["pressure"] + 1.4 * pressure * divergence
    assert np.abs(heat).max() < 1e-3 * np.abs(1.4 * pressure * divergence).max()


def test_blast_of_the_cases():
    cylinder = Blast.of(load("basics/blast"))
    assert (cylinder.dimensions, cylinder.energy) == (2, pytest.approx(np.pi * 0.05**2 * 50.0 / 0.4))
    ball = Blast.of(load("basics/blast-in-space"))
    assert (ball.dimensions, ball.energy) == (3, pytest.approx(4 / 3 * np.pi * 0.1**3 * 50.0 / 0.4))
