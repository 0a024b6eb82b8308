"""Smooth rigid sphere pressed into an elastic layer on a rigid base: linear elasticity; includes Hertz contact with a
half-space.

A sphere of radius R at the depth δ touches a layer of thickness h within the contact radius a. Its pressure, written as the
Hankel transform p̂(k) = ∫₀ᵃ φ(t) cos kt dt with an unknown function φ, displaces the face by 2(1-ν²)/E ∫ L(kh) p̂(k) J₀(kr)
dk, where L is the relative compliance, 1 for the half-space. Equating this to the parabola of the sphere gives Fredholm's
equation φ(t) + 2/π ∫₀ᵃ φ(s) ∫₀^∞ (L-1) cos ks cos kt dk ds = E/(π(1-ν²)) (δ - t²/R), and φ(a) = 0 at the rim of the contact
(N. N. Lebedev & Ya. S. Ufliand, J. Appl. Math. Mech. 22 (1958) 442-450; W. C. Hayes, L. M. Keer, G. Herrmann & L. F.
Mockros, J. Biomech. 5 (1972) 541-551, for the bonded layer).
"""

from math import pi, sqrt
from typing import NamedTuple

import numpy as np

from pellucid.references import Array


class Layer(NamedTuple):
    """An elastic layer on a rigid base, into which a sphere is pressed (`at_contact`): Young's modulus [Pa], Poisson's
    ratio, thickness [m], and whether the layer is bonded to the base or free to slip."""

    young_modulus: float  # [Pa]
    poisson_ratio: float
    thickness: float  # [m]
    bonded: bool  # True: bonded to the base, False: free to slip

    def compliance(self, kh: Array) -> Array:
        """Return the factor L(kh): displacement of the face under a sinusoidal pressure of wave number k, divided by the
        displacement of a half-space (no unit)."""
        x = np.minimum(kh, 300.0)
        if not self.bonded:
            share: Array = 2.0 * np.sinh(x) ** 2 / (np.sinh(2.0 * x) + 2.0 * x)
            return share
        m = 3.0 - 4.0 * self.poisson_ratio
        held: Array = (2.0 * m * np.sinh(2.0 * x) - 4.0 * x) / (2.0 * m * np.cosh(2.0 * x) + 4.0 * x * x + 1.0 + m * m)
        return held


def at_contact(layer: Layer, radius: float, contact: float) -> tuple[float, float]:
    """Return the depth [m] to which a sphere of the radius `radius` [m] is pressed into a layer, and the force on the
    sphere [N], for a contact of the radius `contact` [m].

    Raises ValueError if the contact is wider than two thicknesses, which the quadrature does not resolve.
    """
    if contact > 2.0 * layer.thickness:
        raise ValueError(
            f"a contact radius of {contact:g} m is more than twice the thickness of "
            f"{layer.thickness:g} m, the limit of the reference solution"
        )
    nodes, weights = np.polynomial.legendre.leggauss(24)
    t, dt = 0.5 * contact * (nodes + 1.0), 0.5 * contact * weights
    t, dt = np.append(t, contact), np.append(dt, 0.0)  # φ at the rim as well
    waves, shares = np.polynomial.legendre.leggauss(200)
    end = 25.0 / layer.thickness
    k, dk = 0.5 * end * (waves + 1.0), 0.5 * end * shares
    cosines = np.cos(np.outer(t, k))
    kernel = 2.0 / pi * (cosines * ((layer.compliance(k * layer.thickness) - 1.0) * dk)) @ cosines.T
    modulus = layer.young_modulus / (pi * (1.0 - layer.poisson_ratio**2))
    sides = modulus * np.stack([np.ones_like(t), -(t**2) / radius], axis=1)
    per_depth, of_shape = np.linalg.solve(np.eye(len(t)) + kernel * dt, sides).T
    depth = -float(of_shape[-1] / per_depth[-1])
    return depth, 2.0 * pi * float(dt @ (depth * per_depth + of_shape))


def force(layer: Layer, radius: float, depth: float) -> float:
    """Return the force [N] on a rigid sphere of a radius [m] at a depth [m] in a layer; the depth must be small compared
    with the radius."""
    low, high = 0.0, sqrt(2.0 * radius * depth)  # a half-space has a = √(Rδ), a bed of springs √(2Rδ)
    for _ in range(45):
        contact = 0.5 * (low + high)
        low, high = (contact, high) if at_contact(layer, radius, contact)[0] < depth else (low, contact)
    return at_contact(layer, radius, 0.5 * (low + high))[1]
