"""Minimum energy of a bag of incompressible liquid with a given width: an axisymmetric membrane.

The skin is rubber that wrinkles instead of carrying compression (compressible neo-Hookean, plane stress) and is spherical
at rest. Its meridian is a chain of cones, symmetric about the equator, whose positions minimize the energy at a given
volume and width. No code is shared with the membranes of the program.
"""

from typing import Any

import numpy as np
from scipy.optimize import minimize

CONES = 12
"""Number of cones from pole to equator."""
NEWTON = 30


def least_energy(radius: float, half_width: float, thickness: float, young_modulus: float, poisson_ratio: float) -> float:
    """Return the minimum energy [J] of a spherical skin of a radius [m] and thickness [m] that is filled with incompressible
    liquid and spread to a half width [m]."""
    E, nu, q = young_modulus, poisson_ratio, half_width / radius
    lam, mu = nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 / (1.0 + nu)  # over E
    angle = np.linspace(0.0, 0.5 * np.pi, CONES + 1)
    rim, height = np.sin(angle), np.cos(angle)
    length, middle = np.hypot(np.diff(rim), np.diff(height)), 0.5 * (rim[1:] + rim[:-1])
    area = 2.0 * np.pi * middle * length
    volume = _volume(rim, height)

    def places(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.concatenate([[0.0], x[: CONES - 1], [q]]), np.concatenate([x[CONES - 1 :], [0.0]])

    def energy(x: np.ndarray) -> float:
        r, z = places(x)
        along = np.hypot(np.diff(r), np.diff(z)) / length
        return float(np.sum(area * _density(along, 0.5 * (r[1:] + r[:-1]) / middle, lam, mu)))

    start = np.concatenate([q * rim[1:-1], height[:-1] / q**2])
    same_volume: Any = {"type": "eq", "fun": lambda x: _volume(*places(x)) / volume - 1.0}
    options: Any = {"maxiter": 500, "ftol": 1e-9}
    found = minimize(energy, start, method="SLSQP", constraints=[same_volume], options=options)
    if not found.success:
        raise ValueError(f"no equilibrium shape of the bag was found for a half width of {q:.3g} radii: {found.message}")
    return float(2.0 * E * thickness * radius**2 * found.fun)  # both halves


def _volume(r: np.ndarray, z: np.ndarray) -> float:
    return float(np.sum(np.pi / 3.0 * (r[1:] ** 2 + r[1:] * r[:-1] + r[:-1] ** 2) * (z[:-1] - z[1:])))


def _density(first: np.ndarray, second: np.ndarray, lam: float, mu: float) -> np.ndarray:
    """Return the strain energy per initial volume [J/m³] for two principal stretches in the plane of the skin, minimized over
    wrinkling and the free thickness. lam, mu: Lamé's constants [Pa]."""
    major, minor = np.maximum(np.maximum(first, second), 1.0), np.minimum(first, second)
    minor = np.maximum(minor, np.sqrt(_squared(major, lam, mu, 1.0)))  # the natural width
    third = np.sqrt(_squared(major * minor, lam, mu, 0.5))
    J = np.log(major * minor * third)
    return np.asarray(0.5 * mu * (major**2 + minor**2 + third**2 - 3.0) - mu * J + 0.5 * lam * J**2)


def _squared(stretched: np.ndarray, lam: float, mu: float, power: float) -> np.ndarray:
    """Return the solution c of μ (c - 1) + λ ln(stretched c^power) = 0: the square of the stress-free principal stretches.

    stretched: product of the given stretches. power: 0.5 for one stress-free direction, 1 for two.
    """
    y = np.zeros_like(stretched)
    for _ in range(NEWTON):
        y -= (mu * (np.exp(y) - 1.0) + lam * (np.log(stretched) + power * y)) / (mu * np.exp(y) + lam * power)
    return np.asarray(np.exp(y))
