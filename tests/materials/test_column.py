"""Fluids at rest under gravity against the closed forms that some equations of state have, and against differences."""

from math import inf

import numpy as np
import pytest
from samples import EOS, fluid

from pellucid.materials.energy_update import pressure
from pellucid.materials.eos.equation import ColumnEnds, states_at_rest
from pellucid.materials.eos.ideal_gas import IdealGas
from pellucid.materials.eos.tait import Tait

G = 9.81


def test_a_gas_is_an_adiabatic_atmosphere():
    """T falls by (γ-1)/γ g/R per height, density and pressure as its powers 1/(γ-1) and γ/(γ-1)."""
    gamma, density, ground = 1.4, 1.2, 1e5
    depth = np.linspace(-9000.0, 9000.0, 301)
    energy = ground / ((gamma - 1.0) * density)
    found, e = states_at_rest(IdealGas(gamma), density, energy, G, depth)
    ratio = 1.0 + (gamma - 1.0) / gamma * density * G * depth / ground
    # the steps of the integration are good to 1e-11, its interpolation to about as much
    assert found == pytest.approx(density * ratio ** (1.0 / (gamma - 1.0)), rel=1e-10)
    assert e == pytest.approx(energy * ratio, rel=1e-10)


@pytest.mark.parametrize("speed", [15.0, 1480.0])
def test_a_liquid_of_tait(speed):
    """c² grows linearly with depth: ρ/ρ₀ = (1 + (n-1) g s/c₀²)^(1/(n-1))."""
    eos, depth = Tait(1000.0, 0.0, speed, 7.0, 0.0), np.linspace(0.0, 2.0, 100)
    density, _ = states_at_rest(eos, 1000.0, 0.0, G, depth)
    exact = 1000.0 * (1.0 + 6.0 * G * depth / speed**2) ** (1.0 / 6.0)
    assert density == pytest.approx(exact, rel=1e-13 if speed > 1000.0 else 1e-10)
    found = np.array([pressure(eos, rho, 0.0) for rho in density])
    assert found == pytest.approx(1000.0 * speed**2 / 7.0 * ((exact / 1000.0) ** 7 - 1.0), rel=1e-8, abs=1e-9)


@pytest.mark.parametrize("kind", EOS)
def test_pressure_grows_by_the_weight_and_entropy_stays(kind):
    """dp/ds = ρ g and de = p/ρ² dρ by central differences, for every equation of state."""
    material = fluid(kind)
    depth = np.linspace(0.0, 100.0, 2001)
    density, state = material.at_rest(G, depth)
    p, e = -state["stress"][:, 0], state["internal_energy"]
    step = depth[1] - depth[0]
    slope = (p[2:] - p[:-2]) / (2.0 * step)
    # second order in (step over scale height), and rounding of a stiff liquid's pressure: 1e-16 ρ c² / step
    scale = density[0] * material.wave_speeds()[0] ** 2
    assert np.abs(slope - G * density[1:-1]).max() < 1e-6 * G * density[0] + 3e-12 * scale / step
    assert np.diff(e) == pytest.approx(0.5 * (p[1:] + p[:-1]) * -np.diff(1.0 / density), rel=1e-3, abs=1e-9)
    assert p[0] == pytest.approx(material.pressure, abs=1e-12 * scale)
    law = material.law().eos
    assert p == pytest.approx([pressure(law, *pair) for pair in zip(density, e, strict=True)], rel=1e-14)


def test_depths_may_come_in_any_order():
    eos, depth = IdealGas(1.4), np.array([3.0, -2.0, 0.0, 7.0, -50.0])
    found, e = states_at_rest(eos, 1.2, 2e5, G, depth)
    order = np.argsort(depth)
    again, e_again = states_at_rest(eos, 1.2, 2e5, G, depth[order])
    assert np.array_equal(found[order], again)
    assert np.array_equal(e[order], e_again)
    assert found[2] == 1.2


@pytest.mark.parametrize(
    ("eos", "energy", "top", "why"),
    [
        (IdealGas(1.4), 1e5, -0.4 * 1e5 * 1.4 / (0.4 * G), "its density falls to zero"),
        (Tait(1000.0, 0.0, 15.0, 7.0, 0.0), 0.0, 0.0, "its pressure falls to its smallest possible value"),
        (Tait(1000.0, 0.0, 15.0, 7.0, -inf), 0.0, -225.0 / (6.0 * G), "its density falls to zero"),
    ],
)
def test_a_column_ends(eos, energy, top, why):
    with pytest.raises(ColumnEnds, match=why) as error:
        states_at_rest(eos, 1000.0, energy, G, np.array([5.0 * top - 1.0]))
    assert error.value.depth == pytest.approx(top, rel=1e-5, abs=1e-9)
