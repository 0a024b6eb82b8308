"""Hyperelastic solids with an isochoric and a volumetric energy, W = W_iso(F̄) + U(J), F̄ = J^(-1/3) F.

Source: Holzapfel 2000, Nonlinear Solid Mechanics, section 6.4. A law defines its isochoric part; its parameters include the
initial density `rho0` [kg/m³]. U is κ/2 (J-1)² with the bulk modulus κ in the parameter `kappa` [Pa], unless the law
registers another `volumetric_energy`. An isotropic law states W_iso as a function of the invariants Ī₁ = tr b̄ and Ī₂ = tr
b̄⁻¹ with b̄ = F̄F̄ᵀ. Stress and stiffness are derived from both functions.
"""

from abc import abstractmethod
from collections.abc import Callable, Mapping, Sequence
from math import sqrt
from typing import Any

from pellucid.jit import point_function, pointwise
from pellucid.jit.elementary import power
from pellucid.materials.derivatives import Energy, derive
from pellucid.materials.hyperelastic import HyperelasticMaterial, hyperelastic
from pellucid.materials.law import (
    Law,
    LawType,
    cauchy_stress,
    energy,
    invariant_curvatures,
    invariant_energy,
    invariant_slopes,
    isochoric_energy,
    isochoric_stiffness,
    isochoric_stress,
    volumetric_energy,
    volumetric_stiffness,
    volumetric_stress,
    wave_speed,
)
from pellucid.materials.trial import Operation
from pellucid.model import parameter
from pellucid.tensors import (
    IDENTITY,
    Symmetric,
    Tensor,
    add,
    cofactor,
    determinant,
    deviator,
    largest_row_sum,
    left_cauchy_green,
    scale,
    trace,
)


class WithModuli(HyperelasticMaterial):
    """Base of hyperelastic solids that return their moduli at rest."""

    @abstractmethod
    def moduli(self) -> tuple[float, float]:
        """Return the shear and bulk moduli at rest [Pa]."""

    def moduli_at_rest(self) -> Mapping[str, float]:
        return dict(zip(("shear modulus", "bulk modulus"), self.moduli(), strict=True))

    def wave_speeds(self) -> tuple[float, float]:
        return float(wave_speed(self.law(), IDENTITY)), sqrt(self.moduli()[0] / self.density)


class ElasticModuli(WithModuli):
    """Base of hyperelastic solids whose Young's modulus and Poisson's ratio at rest follow from their other moduli."""

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio at rest."""
        mu, kappa = self.moduli()
        return (3.0 * kappa - 2.0 * mu) / (6.0 * kappa + 2.0 * mu)

    @property
    def young_modulus(self) -> float:
        """Young's modulus at rest [Pa]."""
        return 2.0 * self.moduli()[0] * (1.0 + self.poisson_ratio)


class DecoupledMaterial(WithModuli):
    """Base of hyperelastic solids whose energy is the sum of an isochoric and a volumetric part."""

    def operations(self, law: Law) -> Mapping[Law, Sequence[Operation]]:
        isochoric = isochoric_energy, isochoric_stress, isochoric_stiffness
        volumetric = volumetric_energy, volumetric_stress, volumetric_stiffness
        return {law: (*isochoric, *volumetric, *super().operations(law)[law])}


class BulkMaterial(ElasticModuli, DecoupledMaterial):
    """Base of hyperelastic solids with separate isochoric and volumetric energies and a given bulk modulus."""

    bulk_modulus: float = parameter("Pa", "bulk modulus κ", gt=0)

    def moduli(self) -> tuple[float, float]:
        law = self.law()
        return 2.0 * sum(invariant_slopes(law, 0.0, 0.0)), volumetric_stiffness(law, 1.0)


def decoupled(law: type[LawType]) -> type[LawType]:
    """Class decorator for a law that defines the isochoric part of energy and stress: register the volumetric energy κ/2
    (J-1)², which the law can replace, and the functions of a hyperelastic law, which follow from both parts."""
    hyperelastic(law)
    point_function(energy, law)(_energy)
    point_function(cauchy_stress, law)(_cauchy_stress)
    point_function(wave_speed, law)(_wave_speed)
    point_function(volumetric_energy, law)(_volumetric_energy)
    return law


@pointwise
def total_stress(law: Any, J: float, isochoric: Symmetric) -> Symmetric:
    """Return the Cauchy stress [Pa], the sum of isochoric and volumetric stress, for an isochoric Kirchhoff stress [Pa] and
    the volume ratio J; law: parameters with the bulk modulus."""
    s, mean = scale(1.0 / J, isochoric), volumetric_stress(law, J)
    return (s[0] + mean, s[1] + mean, s[2] + mean, s[3], s[4], s[5])


@pointwise
def dilatational_stiffness(law: Any, J: float) -> float:
    """Return the largest d²U(det(F + ε m⊗Fᵀn))/dε² over unit vectors m and n [Pa] at the volume ratio J: the volumetric part
    of ρ₀ c² for the speed c of plane waves. det is linear in ε, so it is J² U'' for m = n, or 0 where U'' is negative."""
    return max(volumetric_stiffness(law, J), 0.0) * J * J


def _energy(law, F):
    return isochoric_energy(law, F) + volumetric_energy(law, determinant(F))


def _cauchy_stress(law, F):
    return total_stress(law, determinant(F), isochoric_stress(law, F))


def _wave_speed(law, F):
    return sqrt((dilatational_stiffness(law, determinant(F)) + isochoric_stiffness(law, F)) / law.rho0)


def _volumetric_energy(law, J):
    return 0.5 * law.kappa * (J - 1.0) * (J - 1.0)


@pointwise
def principal_bounds(s: Symmetric) -> tuple[float, float]:
    """Return an upper and a lower bound on the eigenvalues of a positive semidefinite symmetric tensor s (Gershgorin)."""
    return largest_row_sum(s), max(-largest_row_sum(scale(-1.0, s)), 0.0)


@pointwise
def linear_stiffness(high: float, low: float, tr: float) -> float:
    """Return an upper bound on the stiffness (as in `isochoric_stiffness`) of the energy ½ S:C̄ with constant S, from the
    trace `tr` of t = F̄ S F̄ᵀ and the bounds `high` and `low` on its eigenvalues [Pa].

    For m = a n + s e with e perpendicular to n, the stiffness is a² (5/9 tr t - 1/3 n·tn) - 4/3 a s n·te + s² n·tn, with
    |n·te| ≤ (high - low)/2.
    """
    return max(5.0 / 9.0 * tr - low / 3.0, high) + (high - low) / 3.0


@pointwise
def spectral_radius(s: Symmetric) -> float:
    """Return an upper bound on the absolute eigenvalues of a symmetric tensor s (Gershgorin)."""
    return max(largest_row_sum(s), largest_row_sum(scale(-1.0, s)))


def _energy_of_first(law, F):
    return invariant_energy(law, power(determinant(F), -2.0 / 3.0) * trace(left_cauchy_green(F)) - 3.0, 0.0)


def _stress_of_first(law, F):
    factor, b = power(determinant(F), -2.0 / 3.0), left_cauchy_green(F)
    slope, _ = invariant_slopes(law, factor * trace(b) - 3.0, 0.0)
    return scale(2.0 * slope * factor, deviator(b))


@pointwise
def _linear_stiffness_of_first(law, F):
    factor, b = power(determinant(F), -2.0 / 3.0), left_cauchy_green(F)
    slope, _ = invariant_slopes(law, factor * trace(b) - 3.0, 0.0)
    return max(2.0 * slope * factor * _first_stiffness(b), 0.0)


def _stiffness_of_first(law, F):
    factor, b = power(determinant(F), -2.0 / 3.0), left_cauchy_green(F)
    curvature, _, _ = invariant_curvatures(law, factor * trace(b) - 3.0, 0.0)
    radius = 2.0 * factor * spectral_radius(deviator(b))
    return _linear_stiffness_of_first(law, F) + max(curvature, 0.0) * radius * radius


@pointwise
def _with_both(F: Tensor) -> tuple[float, Symmetric, Symmetric, float, float]:
    """Return J^(-2/3), b = F Fᵀ and its cofactor B, and Ī₁ - 3 and Ī₂ - 3."""
    factor, b, B = power(determinant(F), -2.0 / 3.0), left_cauchy_green(F), left_cauchy_green(cofactor(F))
    return factor, b, B, factor * trace(b) - 3.0, factor * factor * trace(B) - 3.0


def _energy_of_both(law, F):
    _, _, _, first, second = _with_both(F)
    return invariant_energy(law, first, second)


def _stress_of_both(law, F):
    # by the Cayley-Hamilton theorem, ∂Ī₂/∂F Fᵀ = -2 dev b̄⁻¹
    factor, b, B, first, second = _with_both(F)
    one, two = invariant_slopes(law, first, second)
    return add(scale(2.0 * one * factor, deviator(b)), scale(-2.0 * two * factor * factor, deviator(B)))


@pointwise
def _linear_stiffness_of_both(law, F):
    factor, b, B, first, second = _with_both(F)
    one, two = invariant_slopes(law, first, second)
    most, least = _second_stiffness(B)
    return 2.0 * factor * (max(one * _first_stiffness(b), 0.0) + factor * max(two * most, two * least))


def _stiffness_of_both(law, F):
    # W₁₁ Ī₁'² + W₂₂ Ī₂'² + 2 W₁₂ Ī₁' Ī₂' with Ī₁' = 2 m·dev b̄ n, Ī₂' = -2 m·dev b̄⁻¹ n
    factor, b, B, first, second = _with_both(F)
    one, two, mixed = invariant_curvatures(law, first, second)
    p, q = 2.0 * factor * spectral_radius(deviator(b)), 2.0 * factor * factor * spectral_radius(deviator(B))
    return _linear_stiffness_of_both(law, F) + max(one, 0.0) * p * p + max(two, 0.0) * q * q + 2.0 * abs(mixed) * p * q


@pointwise
def _first_stiffness(b: Symmetric) -> float:
    """Return an upper bound of ½ J^⅔ d²Ī₁/dε² along m⊗Fᵀn; it is never negative."""
    high, low = principal_bounds(b)
    return linear_stiffness(high, low, trace(b))


@pointwise
def _second_stiffness(B: Symmetric) -> tuple[float, float]:
    """Return an upper and a lower bound of ½ J^(4/3) d²Ī₂/dε² along m⊗Fᵀn, m·Bm + ⅔ a n·Bm - a²/9 tr B; B: cofactor of b.

    For m = a n + s e with e perpendicular to n it is a² (5/3 n·Bn - tr B/9) + s² e·Be + 8/3 a s n·Be.
    """
    high, low = principal_bounds(B)
    apart, third = 2.0 / 3.0 * (high - low), trace(B) / 9.0
    return max(5.0 / 3.0 * high - third, high) + apart, min(5.0 / 3.0 * low - third, low) - apart


def _stiffness_of(W: Energy) -> Callable[..., Any]:
    if W.depends_on(1):
        return _linear_stiffness_of_both if W.is_linear else _stiffness_of_both
    return _linear_stiffness_of_first if W.is_linear else _stiffness_of_first


derive(isochoric_energy, invariant_energy, lambda W: _energy_of_both if W.depends_on(1) else _energy_of_first)
derive(isochoric_stress, invariant_energy, lambda W: _stress_of_both if W.depends_on(1) else _stress_of_first)
derive(isochoric_stiffness, invariant_energy, _stiffness_of)
