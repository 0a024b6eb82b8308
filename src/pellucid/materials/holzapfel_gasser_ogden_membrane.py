"""Sheet with two families of dispersed fibres, W = G/2 (I - 3) + k₁/(2k₂) Σ_i (exp(k₂ ⟨E_i⟩²) - 1).

E_i = d (I - 3) + (1-3d) (I₄ᵢ - 1) is the strain of the family i with a mean direction at ±θ from an axis in the initial
surface, with I = tr C + 1/det C and I₄ᵢ = a_i·Ca_i; the sheet is incompressible. Fibres carry tension only, ⟨E⟩ = max(E,
0). Source: Gasser, Ogden & Holzapfel 2006, J. R. Soc. Interface 3, 15, section 4, with the thickness eliminated.
"""

from collections.abc import Mapping, Sequence
from math import cos, exp, expm1, radians, sin
from typing import Literal, NamedTuple

import numpy as np
from pydantic import field_validator

from pellucid.findings import Refusal
from pellucid.jit import point_function, pointwise
from pellucid.materials.law import Law
from pellucid.materials.membrane import InPlane, Shape
from pellucid.materials.membrane_gradient import larger_principal, left_stretch_squared
from pellucid.materials.surface_law import surface_energy, surface_stiffness, surface_tension
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial
from pellucid.materials.trial import Operation
from pellucid.model import Vector, check, parameter
from pellucid.units import in_degrees


class HolzapfelGasserOgdenSurface(NamedTuple):
    """Parameters of the Holzapfel-Gasser-Ogden law of a sheet: shear modulus G of the matrix [N/m], stiffness k₁ [N/m],
    exponent k₂ and dispersion of the fibres, cosine and sine of the fibre angle θ."""

    G: float
    k1: float
    k2: float
    dispersion: float
    cosine: float
    sine: float


class HolzapfelGasserOgdenMembraneMaterial(SurfaceMembraneMaterial):
    """Neo-Hookean sheet with two families of fibres at ±θ from a direction in its surface. The fibres stiffen exponentially
    and carry tension only: walls of arteries and other tissue. The moduli at rest are the moduli of the matrix."""

    kind: Literal["holzapfel-gasser-ogden-membrane"] = "holzapfel-gasser-ogden-membrane"
    shear_modulus: float = parameter("N/m", "surface shear modulus G of the matrix", gt=0)
    k1: float = parameter("N/m", "stiffness k₁ of a family of fibres", ge=0)
    k2: float = parameter("", "exponent k₂ of the fibre stiffening", gt=0)
    dispersion: float = parameter(
        "",
        "dispersion of the fibres: 0 for parallel fibres, 1/3 for an isotropic distribution",
        ge=0,
        le=1 / 3,
    )
    fibre_direction: Vector = parameter(
        "", "reference direction of the fibre angle at the start, of any length; it is projected onto the surface"
    )
    fibre_angle: float = parameter(
        "", 'angle ±θ of the two families, in degrees, or a text with a unit such as "0.3 rad"', ge=0, le=90
    )

    _in_degrees = field_validator("fibre_angle", mode="before")(in_degrees)

    @field_validator("fibre_direction")
    @classmethod
    def _is_a_direction(cls, direction: Vector) -> Vector:
        if not any(direction):
            raise ValueError("fibre_direction = [0, 0, 0] has no direction; give a vector along the surface")
        return direction

    @check
    def _bears_compression(self) -> None:
        if self.wrinkling:
            raise Refusal(
                "wrinkling = true cannot be combined with fibres: wrinkles would not be along the largest stretch",
                "remove `wrinkling`, or use a law without directions",
            )

    @property
    def direction(self) -> np.ndarray:
        return np.array(self.fibre_direction)

    def elastic_law(self) -> HolzapfelGasserOgdenSurface:
        angle = radians(self.fibre_angle)
        numbers = (self.shear_modulus, self.k1, self.k2, self.dispersion)
        return HolzapfelGasserOgdenSurface(*numbers, cos(angle), sin(angle))

    def operations(self) -> Mapping[Law, Sequence[Operation]]:
        return {self.elastic_law(): (surface_energy, surface_tension, surface_stiffness)}

    def surface_moduli(self) -> tuple[float, float]:
        """Return the shear modulus G and the area modulus 3G [N/m] of the isotropic matrix around the fibres."""
        return self.shear_modulus, 3.0 * self.shear_modulus


@pointwise
def _matrix(F: Shape) -> tuple[InPlane, float, float]:
    """Return three values for the isotropic matrix around the fibres at the in-plane deformation gradient F, with the
    invariant I = tr C + 1/det C: its derivative ∂I/∂C pushed forward to the current surface, b - 1/J² times the unit
    tensor; I - 3; and J⁻²."""
    b, J = left_stretch_squared(F), F[0] * F[3] - F[1] * F[2]
    inverse = 1.0 / (J * J)
    return (b[0] - inverse, b[1] - inverse, b[2]), (b[0] - 1.0) + (b[1] - 1.0) + (inverse - 1.0), inverse


@pointwise
def _family(law: HolzapfelGasserOgdenSurface, F: Shape, side: float) -> tuple[InPlane, float]:
    """Return the derivative of the fibre strain E by C pushed forward to the current surface, F ∂E/∂C Fᵀ, and E, for the
    fibres on one side of the axis at the in-plane deformation gradient F; side: 1 or -1."""
    x, y = law.cosine, side * law.sine
    u, v = F[0] * x + F[1] * y, F[2] * x + F[3] * y
    matrix, excess, _ = _matrix(F)
    d = law.dispersion
    along = 1.0 - 3.0 * d
    h = d * matrix[0] + along * u * u, d * matrix[1] + along * v * v, d * matrix[2] + along * u * v
    return h, d * excess + along * (u * u + v * v - (x * x + y * y))


@point_function(surface_energy, HolzapfelGasserOgdenSurface)
def _energy(law, F):
    total = 0.5 * law.G * _matrix(F)[1]
    for side in (1.0, -1.0):
        _, strain = _family(law, F, side)
        if strain > 0.0:
            total += 0.5 * law.k1 / law.k2 * expm1(law.k2 * strain * strain)
    return total


@point_function(surface_tension, HolzapfelGasserOgdenSurface)
def _tension(law, F):
    matrix, _, _ = _matrix(F)
    t11, t22, t12 = law.G * matrix[0], law.G * matrix[1], law.G * matrix[2]
    for side in (1.0, -1.0):
        h, strain = _family(law, F, side)
        if strain > 0.0:
            pull = 2.0 * law.k1 * strain * exp(law.k2 * strain * strain)
            t11 += pull * h[0]
            t22 += pull * h[1]
            t12 += pull * h[2]
    return t11, t22, t12


@point_function(surface_stiffness, HolzapfelGasserOgdenSurface)
def _stiffness(law, F):
    # ∂²I/∂C² pushed forward, of plane waves J⁻² (1 + (m·n)²) at the most; of a family ψ'' (∂E/∂C)⊗(∂E/∂C) + ψ' ∂²E/∂C²; slack
    # fibres count as taut: they may be so at the end of a step
    _, _, inverse = _matrix(F)
    total = 4.0 * law.G * inverse
    for side in (1.0, -1.0):
        h, strain = _family(law, F, side)
        taut = strain if strain > 0.0 else 0.0
        growth = law.k1 * exp(law.k2 * taut * taut)
        size = max(larger_principal(h), larger_principal((-h[0], -h[1], -h[2])))
        total += (
            8.0 * law.dispersion * growth * taut * inverse + 4.0 * growth * (1.0 + 2.0 * law.k2 * taut * taut) * size * size
        )
    return total
