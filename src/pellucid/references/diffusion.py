"""Exact diffusion: a bar whose ends are held at zero, and spherical harmonics."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TERMS, POINTS = 200, 800


def between_zero_ends(start: Callable[[Array], Array], length: float, spread: float, x: Array) -> Array:
    """The concentration at x [m] on a bar from 0 to `length` [m] that begins as `start`.

    spread: diffusivity times time [m²]. The Fourier series of Benet 2015, eq. 4.38, whose integrals are found by Gauss's
    quadrature; good to round-off once the last of its terms has faded.
    """
    wave = np.arange(1, TERMS + 1) * np.pi / length
    points, weights = np.polynomial.legendre.leggauss(POINTS)
    y = 0.5 * length * (points + 1.0)
    parts = np.sin(np.outer(wave, y)) @ (weights * start(y))  # length/2 of the rule cancels the 2/length of the series
    return np.sin(np.outer(x, wave)) @ (parts * np.exp(-(wave**2) * spread))


def harmonic_decay(degree: int, radius: float, diffusivity: float) -> float:
    """The rate at which spherical harmonics of a degree l fade on a sphere, l (l + 1) D/R² [1/s]."""
    return degree * (degree + 1) * diffusivity / radius**2
