"""Exact diffusion: a bar with zero concentration at its ends, and spherical harmonics."""

from collections.abc import Callable

import numpy as np

from pellucid.references.annotations import Array

TERMS = 200


def between_zero_ends(start: Callable[[Array], Array], length: float, spread: float, x: Array) -> Array:
    """Return the concentration at positions x [m] on a bar from 0 to `length` [m] with the initial concentration `start`.

    spread: diffusivity times time [m²]. Fourier series of Benet 2015, eq. 4.38, with integrals by Gauss quadrature;
    accurate to round-off once the highest term has decayed.
    """
    wave = np.arange(1, TERMS + 1) * np.pi / length
    points, weights = np.polynomial.legendre.leggauss(10)  # in as many parts as the highest wave has half-waves
    y = (length / TERMS * (np.arange(TERMS)[:, None] + 0.5 * (points + 1.0))).ravel()
    parts = np.sin(np.outer(wave, y)) @ (np.tile(weights, TERMS) * start(y)) / TERMS
    return np.sin(np.outer(x, wave)) @ (parts * np.exp(-(wave**2) * spread))


def harmonic_decay(degree: int, radius: float, diffusivity: float) -> float:
    """Return the decay rate of the concentration of a spherical harmonic of degree l on a sphere, l (l + 1) D/R² [1/s], with
    the radius R [m] and the diffusivity D [m²/s]."""
    return degree * (degree + 1) * diffusivity / radius**2
