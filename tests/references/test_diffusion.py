"""Exact diffusion against other ways to the same numbers."""

import numpy as np
import pytest

from pellucid.references.flows import between_zero_ends, harmonic_decay


def test_the_bar_of_the_thesis():
    """x (x - 1)(x - 1/2)(x - 1/4), D = 0.1, t = 0.1: values found with the integrals of the series in closed form."""
    x = np.array([0.1, 0.25, 0.5, 0.75, 0.9])
    found = between_zero_ends(lambda y: y * (y - 1.0) * (y - 0.5) * (y - 0.25), 1.0, 0.01, x)
    assert found == pytest.approx([-0.00112962, -0.00045282, -0.00380243, -0.01672610, -0.01132750], abs=5e-9)


def test_a_sine_fades_by_its_own_rate():
    x = np.linspace(0.0, 2.0, 7)
    found = between_zero_ends(lambda y: np.sin(1.5 * np.pi * y), 2.0, 0.05, x)
    assert found == pytest.approx(np.sin(1.5 * np.pi * x) * np.exp(-((1.5 * np.pi) ** 2) * 0.05), abs=1e-13)


def test_a_harmonic_obeys_the_equation_of_diffusion():
    """z³ - 3/5 z r² on a sphere of radius 2: the Laplacian of its constant extension along rays, by differences."""

    def on_rays(p):
        n = p / np.linalg.norm(p)
        return n[2] ** 3 - 0.6 * n[2]

    place, h = np.array([1.2, -0.8, 1.4]), 1e-3
    place *= 2.0 / np.linalg.norm(place)
    laplacian = sum(on_rays(place + s * h * e) for e in np.eye(3) for s in (1.0, -1.0)) - 6.0 * on_rays(place)
    assert -0.3 * laplacian / h**2 / on_rays(place) == pytest.approx(harmonic_decay(3, 2.0, 0.3), rel=1e-5)
