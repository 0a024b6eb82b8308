"""The exact elastic solutions satisfy their equations."""

import numpy as np
import pytest

from pellucid.case import load
from pellucid.references.solids import SpinningDisc, StandingWave, period_of


def test_standing_wave_satisfies_the_wave_equation():
    wave = StandingWave(2.0, 3.0, 0.4, 1.7)
    x, t, h = np.linspace(0, 2, 9), 0.6, 1e-3
    u_tt = (wave.displacement(x, t + h) - 2 * wave.displacement(x, t) + wave.displacement(x, t - h)) / h**2
    u_xx = (wave.displacement(x + h, t) - 2 * wave.displacement(x, t) + wave.displacement(x - h, t)) / h**2
    assert np.allclose(u_tt, wave.speed**2 * u_xx, atol=1e-5)
    rate = (wave.displacement(x, t + h) - wave.displacement(x, t - h)) / (2 * h)
    assert np.allclose(rate, wave.velocity(x, t), atol=1e-5)


def test_standing_wave_of_the_case():
    wave = StandingWave.of(load("basics/elastic-wave"))
    assert wave.speed == pytest.approx(1.0)
    assert wave.period == pytest.approx(1.0)
    assert wave.velocity(np.array([0.0, 0.5, 1.0]), 0.2) == pytest.approx(np.zeros(3), abs=1e-21)  # held at the walls


def test_period_of():
    times = np.linspace(0, 10, 2001)
    assert period_of(times, np.sin(2 * np.pi * times / 0.7 + 0.2)) == pytest.approx(0.7, rel=1e-4)
    assert np.isnan(period_of(times, np.ones(2001)))


DISC = SpinningDisc(0.5, 1000.0, 1e5, 0.3, 1.0)


def test_disc_starts_at_rest_and_unstressed():
    r = np.linspace(0.05, 0.45, 9)
    static = DISC.stresses(r)[0].max()
    assert np.abs(DISC.displacement(r, 0.0)).max() < 1e-5 * np.abs(DISC.displacement(r, 0.06)).max()
    assert np.abs(DISC.stresses(r, 0.0)[0]).max() < 1e-2 * static  # twenty modes: the stress converges more slowly


def test_disc_has_a_free_rim():
    assert abs(DISC.stresses(0.5)[0]) < 1e-12
    assert abs(DISC.stresses(0.5, 0.123)[0]) < 1e-8


def test_static_disc_carries_the_centrifugal_force():
    r, h = np.linspace(0.05, 0.45, 9), 1e-5
    radial, hoop = DISC.stresses(r)
    slope = (DISC.stresses(r + h)[0] - DISC.stresses(r - h)[0]) / (2 * h)
    assert np.allclose(slope + (radial - hoop) / r, -1000.0 * r, rtol=1e-6)


def test_breathing_disc_satisfies_its_equation_of_motion():
    r, t, h = np.linspace(0.05, 0.45, 9), 0.0721, 1e-5
    radial, hoop = DISC.stresses(r, t)
    slope = (DISC.stresses(r + h, t)[0] - DISC.stresses(r - h, t)[0]) / (2 * h)
    u = [DISC.displacement(r, t + k * 1e-4) for k in (-1, 0, 1)]
    acceleration = (u[0] - 2 * u[1] + u[2]) / 1e-8
    residual = slope + (radial - hoop) / r + 1000.0 * r - 1000.0 * acceleration
    assert np.abs(residual).max() < 0.02 * 1000.0 * 0.5


def test_mean_stress_swings_about_the_virial():
    assert DISC.static_mean_stress == pytest.approx(125.0)
    times = np.arange(4000) * (DISC.breathing[2][0] and 2 * np.pi / DISC.breathing[2][0]) / 100  # forty first periods
    assert DISC.mean_stress(times).mean() == pytest.approx(125.0, rel=1e-3)
    r = (np.arange(4000) + 0.5) / 4000 * 0.5
    radial, hoop = DISC.stresses(r, 0.05)
    assert np.sum((radial + hoop) * r) / np.sum(r) == pytest.approx(DISC.mean_stress(0.05)[0], rel=1e-5)
