"""Soft tissue with dispersed fibres, W = μ/2 (Ī₁-3) + κ/2 (J-1)² + Σ_i k₁/(2k₂) (exp(k₂ ⟨E_i⟩²) - 1).

E_i = d (Ī₁-3) + (1-3d) (Ī₄ᵢ-1) is the strain of the fibre family i with the mean direction a_i in the reference
configuration and the dispersion d, from 0 (all parallel) to 1/3 (isotropic), with Ī₄ᵢ = a_i·C̄a_i. Fibres carry tension
only: ⟨E⟩ = max(E, 0), so that their stress starts without a jump. Source: Gasser, Ogden & Holzapfel 2006, J. R. Soc.
Interface 3, 15, section 4.
"""

from math import exp, expm1, hypot
from typing import Literal, NamedTuple

from pydantic import field_validator

from pellucid.jit import point_function, pointwise
from pellucid.jit.elementary import power
from pellucid.materials.decoupled import (
    BulkMaterial,
    decoupled,
    linear_stiffness,
    principal_bounds,
    spectral_radius,
)
from pellucid.materials.law import isochoric_energy, isochoric_stiffness, isochoric_stress
from pellucid.model import Vector, parameter
from pellucid.tensors import Symmetric, Tensor, add, determinant, deviator, left_cauchy_green, scale, trace


@decoupled
class HolzapfelGasserOgden(NamedTuple):
    """Parameters of the Holzapfel-Gasser-Ogden law: shear modulus μ of the matrix [Pa], stiffness k₁ [Pa], exponent k₂ and
    dispersion of the fibres, unit vectors along the fibre families (concatenated), bulk modulus [Pa], initial density
    [kg/m³]."""

    mu: float
    k1: float
    k2: float
    dispersion: float
    fibres: tuple[float, ...]
    kappa: float
    rho0: float


class HolzapfelGasserOgdenMaterial(BulkMaterial):
    """Neo-Hookean matrix with one or two families of fibres that stiffen exponentially and carry tension only: arteries,
    heart muscle, and other soft tissue, at any strain. The moduli at rest are the moduli of the matrix."""

    kind: Literal["holzapfel-gasser-ogden"] = "holzapfel-gasser-ogden"
    shear_modulus: float = parameter("Pa", "shear modulus μ of the matrix", gt=0)
    k1: float = parameter("Pa", "stiffness k₁ of a family of fibres", ge=0)
    k2: float = parameter("", "exponent k₂ of the fibre stiffening", gt=0)
    dispersion: float = parameter(
        "",
        "dispersion of the fibres: 0 for parallel fibres, 1/3 for an isotropic distribution",
        ge=0,
        le=1 / 3,
    )
    fibres: tuple[Vector, ...] = parameter(
        "", "mean directions of the fibre families in the reference configuration, of any length", min_length=1, max_length=2
    )

    @field_validator("fibres")
    @classmethod
    def _have_directions(cls, fibres: tuple[Vector, ...]) -> tuple[Vector, ...]:
        for number, direction in enumerate(fibres):
            if not any(direction):
                raise ValueError(f"fibres[{number}] = [0, 0, 0] has no direction; give a vector along the fibres")
        return fibres

    def moduli(self) -> tuple[float, float]:
        """Return the shear and bulk moduli [Pa] of the isotropic matrix around the fibres."""
        return self.shear_modulus, self.bulk_modulus

    def law(self) -> HolzapfelGasserOgden:
        units = [x / hypot(*direction) for direction in self.fibres for x in direction]
        numbers = (self.shear_modulus, self.k1, self.k2, self.dispersion, tuple(units))
        return HolzapfelGasserOgden(*numbers, self.bulk_modulus, self.density)


@pointwise
def _along(F: Tensor, fibres: tuple[float, ...], family: int) -> tuple[Symmetric, float]:
    """Return (F a)⊗(F a) for the unit direction a of a family of fibres, as a 6-tuple, and a·a, which is 1 up to rounding.
    F: deformation gradient; fibres: directions of all families, concatenated; family: index of the family."""
    x, y, z = fibres[3 * family], fibres[3 * family + 1], fibres[3 * family + 2]
    u = F[0] * x + F[1] * y + F[2] * z
    v = F[3] * x + F[4] * y + F[5] * z
    w = F[6] * x + F[7] * y + F[8] * z
    return (u * u, v * v, w * w, v * w, u * w, u * v), x * x + y * y + z * z


@pointwise
def _structure(law: HolzapfelGasserOgden, b: Symmetric, F: Tensor, J: float, family: int) -> tuple[Symmetric, float]:
    """Return the tensor h = d b̄ + (1-3d) ā⊗ā of a family of fibres with dispersion d, as a 6-tuple, and its strain E = tr h
    - 1, exactly 0 at rest. b: left Cauchy-Green tensor F Fᵀ; J: volume ratio; b̄ and ā are computed with F̄ = J^(-1/3) F."""
    d, factor = law.dispersion, power(J, -2.0 / 3.0)
    fibre, one = _along(F, law.fibres, family)
    strain = d * (factor * trace(b) - 3.0) + (1.0 - 3.0 * d) * (factor * trace(fibre) - one)
    return add(scale(d * factor, b), scale((1.0 - 3.0 * d) * factor, fibre)), strain


@point_function(isochoric_energy, HolzapfelGasserOgden)
def _isochoric_energy(law, F):
    J, b = determinant(F), left_cauchy_green(F)
    total = 0.5 * law.mu * (power(J, -2.0 / 3.0) * trace(b) - 3.0)
    for family in range(len(law.fibres) // 3):
        _, strain = _structure(law, b, F, J, family)
        if strain > 0.0:
            total += 0.5 * law.k1 / law.k2 * expm1(law.k2 * strain * strain)
    return total


@point_function(isochoric_stress, HolzapfelGasserOgden)
def _isochoric_stress(law, F):
    J, b = determinant(F), left_cauchy_green(F)
    stress = scale(law.mu * power(J, -2.0 / 3.0), b)
    for family in range(len(law.fibres) // 3):
        h, strain = _structure(law, b, F, J, family)
        if strain > 0.0:
            stress = add(stress, scale(2.0 * law.k1 * strain * exp(law.k2 * strain * strain), h))
    return deviator(stress)


@point_function(isochoric_stiffness, HolzapfelGasserOgden)
def _isochoric_stiffness(law, F):
    # of a family ψ'' (dE/dε)² + ψ' d²E/dε², with dE/dε = 2 dev h : m⊗n; slack fibres count as taut: they may be so at the
    # end of a step
    J, b = determinant(F), left_cauchy_green(F)
    high, low = principal_bounds(b)
    total = law.mu * power(J, -2.0 / 3.0) * linear_stiffness(high, low, trace(b))
    for family in range(len(law.fibres) // 3):
        h, strain = _structure(law, b, F, J, family)
        square = strain * strain if strain > 0.0 else 0.0
        growth = exp(law.k2 * square)
        if strain > 0.0:
            high, low = principal_bounds(h)
            total += 2.0 * law.k1 * strain * growth * linear_stiffness(high, low, trace(h))
        size = spectral_radius(deviator(h))
        total += 4.0 * law.k1 * (1.0 + 2.0 * law.k2 * square) * growth * size * size
    return total
