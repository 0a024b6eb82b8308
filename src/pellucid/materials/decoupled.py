"""Hyperelastic solids with an isochoric and a volumetric energy, W = W_iso(F̄) + κ/2 (J-1)², F̄ = J^(-1/3) F.

Source: Holzapfel 2000, Nonlinear Solid Mechanics, section 6.4. A law defines its isochoric part; its parameters include the
bulk modulus `kappa` [Pa] and the initial density `rho0` [kg/m³].
"""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from math import sqrt
from typing import Any

from pellucid.jit import generic, point_function, pointwise
from pellucid.materials.hyperelastic import HyperelasticMaterial, hyperelastic
from pellucid.materials.law import Law, LawType, cauchy_stress, energy, volumetric_energy, volumetric_stress, wave_speed
from pellucid.materials.trial import Operation
from pellucid.model import parameter
from pellucid.tensors import IDENTITY, Symmetric, Tensor, determinant, largest_row_sum, scale


@generic
def isochoric_energy(law: Law, F: Tensor) -> float:
    """Return the isochoric energy W_iso per unit reference volume [J/m³]; it depends on the isochoric part F̄ of the
    deformation gradient F only."""


@generic
def isochoric_stress(law: Law, F: Tensor) -> Symmetric:
    """Return the isochoric Kirchhoff stress ∂W_iso/∂F Fᵀ [Pa] at the deformation gradient F, a deviator."""


@generic
def isochoric_stiffness(law: Law, F: Tensor) -> float:
    """Return the largest d²W_iso(F + ε m⊗Fᵀn)/dε² at ε = 0 over unit vectors m and n [Pa], or an upper bound: the isochoric
    part of ρ₀ c² for the speed c of plane waves."""


class DecoupledMaterial(HyperelasticMaterial):
    """Base of hyperelastic solids whose energy is the sum of an isochoric and a volumetric part."""

    @abstractmethod
    def moduli(self) -> tuple[float, float]:
        """Return the shear and bulk moduli at rest [Pa]."""

    def wave_speeds(self) -> tuple[float, float]:
        return float(wave_speed(self.law(), IDENTITY)), sqrt(self.moduli()[0] / self.density)

    def operations(self, law: Law) -> Mapping[Law, Sequence[Operation]]:
        return {law: (isochoric_energy, isochoric_stress, isochoric_stiffness, *super().operations(law)[law])}


class BulkMaterial(DecoupledMaterial):
    """Base of hyperelastic solids with separate isochoric and volumetric energies and a given bulk modulus."""

    bulk_modulus: float = parameter("Pa", "bulk modulus κ", gt=0)

    @property
    def poisson_ratio(self) -> float:
        """Poisson's ratio at rest."""
        mu, kappa = self.moduli()
        return (3.0 * kappa - 2.0 * mu) / (6.0 * kappa + 2.0 * mu)

    @property
    def young_modulus(self) -> float:
        """Young's modulus at rest [Pa]."""
        return 2.0 * self.moduli()[0] * (1.0 + self.poisson_ratio)


def decoupled(law: type[LawType]) -> type[LawType]:
    """Class decorator for a law that defines only the isochoric part of energy and stress: add the volumetric part, which
    follows from the bulk modulus, and register the functions of a hyperelastic law as `hyperelastic` does."""
    hyperelastic(law)
    point_function(energy, law)(_energy)
    point_function(cauchy_stress, law)(_cauchy_stress)
    point_function(wave_speed, law)(_wave_speed)
    point_function(volumetric_energy, law)(_volumetric_energy)
    point_function(volumetric_stress, law)(_volumetric_stress)
    return law


@pointwise
def total_stress(law: Any, J: float, isochoric: Symmetric) -> Symmetric:
    """Return the Cauchy stress [Pa], the sum of isochoric and volumetric stress, for an isochoric Kirchhoff stress [Pa] and
    the volume ratio J; law: parameters with the bulk modulus."""
    s, mean = scale(1.0 / J, isochoric), volumetric_stress(law, J)
    return (s[0] + mean, s[1] + mean, s[2] + mean, s[3], s[4], s[5])


def _energy(law, F):
    return isochoric_energy(law, F) + volumetric_energy(law, determinant(F))


def _cauchy_stress(law, F):
    return total_stress(law, determinant(F), isochoric_stress(law, F))


def _wave_speed(law, F):
    # cof F is affine along m⊗Fᵀn: of the volumetric part J² U'' alone resists, along n
    J = determinant(F)
    return sqrt((law.kappa * J * J + isochoric_stiffness(law, F)) / law.rho0)


def _volumetric_energy(law, J):
    return 0.5 * law.kappa * (J - 1.0) * (J - 1.0)


def _volumetric_stress(law, J):
    return law.kappa * (J - 1.0)


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
