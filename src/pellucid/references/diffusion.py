"""Exact diffusion: a bar whose ends are held at zero, and spherical harmonics."""

from collections.abc import Callable

import numpy as np

from pellucid.references.annotations import Array

TERMS = 200


def between_zero_ends(start: Callable[[Array], Array], length: float, spread: float, x: Array) -> Array:
    """The concentration at x [m] on a bar from 0 to `length` [m] that begins as `start`.

    spread: diffusivity times time [m²]. The Fourier series of Benet 2015, eq. 4.38, whose integrals are found by Gauss's
    quadrature; good to round-off once the last of its terms has faded.
    """
    wave = np.arange(1, TERMS + 1) * np.pi / length
    points, weights = np.polynomial.legendre.leggauss(10)  # in as many parts as the highest wave has half-waves
    y = (length / TERMS * (np.arange(TERMS)[:, None] + 0.5 * (points + 1.0))).ravel()
    parts = np.sin(np.outer(wave, y)) @ (np.tile(weights, TERMS) * start(y)) / TERMS
    return np.sin(np.outer(x, wave)) @ (parts * np.exp(-(wave**2) * spread))


def harmonic_decay(degree: int, radius: float, diffusivity: float) -> float:
    """The rate at which spherical harmonics of a degree l fade on a sphere, l (l + 1) D/R² [1/s]."""
    return degree * (degree + 1) * diffusivity / radius**2
