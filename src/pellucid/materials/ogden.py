"""Decoupled Ogden solid, W = Σ_p μ_p/α_p (λ̄₁^α_p + λ̄₂^α_p + λ̄₃^α_p - 3) + κ/2 (J-1)², with λ̄ = J^(-1/3) λ.

Source: Ogden 1972, Proc. R. Soc. Lond. A 328, 567, in the decoupled form of Holzapfel 2000, Nonlinear Solid Mechanics,
section 6.5. At rest 2μ = Σ μ_p α_p. All functions use `expm1` of the principal logarithmic strains e = ln λ̄, which is
accurate at small strains, and the difference of the two closest strains, which is accurate if they are nearly equal.
"""

from typing import Literal, NamedTuple

from pydantic import ValidationInfo, field_validator

from pellucid.jit import point_function, pointwise
from pellucid.jit.elementary import expm1, log, log1p
from pellucid.materials.decoupled import (
    BulkMaterial,
    decoupled,
    total_stress,
)
from pellucid.materials.law import (
    energy_and_stress,
    isochoric_energy,
    isochoric_stiffness,
    isochoric_stress,
    volumetric_energy,
)
from pellucid.materials.principal import THIRD, Spectrum, Triple, isotropic_deviator, spectrum
from pellucid.model import parameter
from pellucid.tensors import Symmetric, determinant, left_cauchy_green, piola_transform


@decoupled
class Ogden(NamedTuple):
    """Parameters of the Ogden law: moduli μ_p [Pa] and exponents α_p of the terms, bulk modulus [Pa], initial density
    [kg/m³]."""

    moduli: tuple[float, ...]
    exponents: tuple[float, ...]
    kappa: float
    rho0: float


def check_terms(moduli: tuple[float, ...], exponents: tuple[float, ...]) -> None:
    """Check the moduli [Pa] and exponents of the terms of an Ogden law. Raises ValueError if their numbers differ, or if a
    term has no positive stiffness."""
    if moduli and len(moduli) != len(exponents):
        raise ValueError(f"shear_moduli has {len(moduli)} numbers but exponents {len(exponents)}: give one of each per term")
    for number, (mu, alpha) in enumerate(zip(moduli, exponents, strict=False)):
        if not mu * alpha > 0.0:
            terms = f"shear_moduli[{number}] = {mu:g} and exponents[{number}] = {alpha:g}"
            raise ValueError(f"{terms}: their product must be positive; give both the same sign")


class OgdenMaterial(BulkMaterial):
    """Ogden solid, W = Σ μ_p/α_p (λ̄₁^α_p + λ̄₂^α_p + λ̄₃^α_p - 3) + κ/2 (J-1)²: any strain; at rest 2μ = Σ μ_p α_p."""

    kind: Literal["ogden"] = "ogden"
    shear_moduli: tuple[float, ...] = parameter(
        "Pa", "moduli μ_p of the terms, each with the sign of its exponent", min_length=1
    )
    exponents: tuple[float, ...] = parameter("", "exponents α_p of the terms", min_length=1)

    @field_validator("exponents")
    @classmethod
    def _terms_resist(cls, exponents: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        check_terms(info.data.get("shear_moduli", ()), exponents)
        return exponents

    def moduli(self) -> tuple[float, float]:
        return 0.5 * sum(mu * alpha for mu, alpha in zip(self.shear_moduli, self.exponents, strict=True)), self.bulk_modulus

    def law(self) -> Ogden:
        return Ogden(self.shear_moduli, self.exponents, self.bulk_modulus, self.density)


@pointwise
def _strains(of: Spectrum) -> tuple[Triple, float]:
    """Return the isochoric logarithmic principal strains ln λ̄, from the spectrum of b = F Fᵀ with the eigenvalues x = λ²,
    and the difference between the second and the third strain."""
    above = 0.5 * log1p(of.distance / of.values[2])
    a, c = 0.5 * log(of.values[0]), 0.5 * log(of.values[2])
    mean = THIRD * (a + c + c + above)
    return (a - mean, c - mean + above, c - mean), above


@pointwise
def _energy_and_deviator(law: Ogden, of: Spectrum) -> tuple[float, Symmetric]:
    """Return the isochoric energy W_iso [J/m³] and the isochoric Kirchhoff stress dev Σ_p μ_p b̄^(α_p/2) [Pa], from the
    spectrum of b = F Fᵀ."""
    (first, _, third), above = _strains(of)
    stored = apart = slope = 0.0  # slope: of the stress over the strain from the third to the second
    for p in range(len(law.moduli)):
        mu, alpha = law.moduli[p], law.exponents[p]
        x, z, y = expm1(alpha * first), expm1(alpha * third), alpha * above
        growth = expm1(y)
        more = (1.0 + z) * growth
        stored += mu / alpha * (x + z + z + more)
        apart += mu * (x - z - more)
        slope += mu * alpha * (1.0 + z) * (growth / y if y != 0.0 else 1.0)
    strain_slope = above / of.distance if above != 0.0 else 0.5 / of.values[2]
    return stored, isotropic_deviator(of, apart, slope * strain_slope)


@point_function(isochoric_energy, Ogden)
def _isochoric_energy(law, F):
    return _energy_and_deviator(law, spectrum(left_cauchy_green(F)))[0]


@point_function(isochoric_stress, Ogden)
def _isochoric_stress(law, F):
    return _energy_and_deviator(law, spectrum(left_cauchy_green(F)))[1]


@point_function(energy_and_stress, Ogden)
def _energy_and_stress(law, F):
    J = determinant(F)
    stored, deviator = _energy_and_deviator(law, spectrum(left_cauchy_green(F)))
    return stored + volumetric_energy(law, J), piola_transform(total_stress(law, J, deviator), F)


@point_function(isochoric_stiffness, Ogden)
def _isochoric_stiffness(law, F):
    # In principal axes with l = m⊗n the stiffness is Σ_i (w_ii - τ_i) l_ii² + Σ_i≠j w_ij l_ii l_jj + Σ_i≠j (k_ij l_ij² +
    # (k_ij - τ_j) l_ij l_ji), with w = ∂²W/∂e∂e and k_ij = λ_j² (τ_i - τ_j)/(λ_i² - λ_j²) (Ogden 1984, Non-Linear Elastic
    # Deformations, section 6.1). For l = m⊗n, l_ij l_ji = l_ii l_jj and Σ_ij l_ij² = 1. What all pairs have alike, c, acts
    # on (tr l)² ≤ 1, the rest is bounded by its row sums.
    of = spectrum(left_cauchy_green(F))
    x, (e, _) = of.values, _strains(of)
    y, slope = (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)  # Σ μ (λ̄^α - 1), Σ μ α λ̄^α
    for p in range(len(law.moduli)):
        mu, alpha = law.moduli[p], law.exponents[p]
        a, b, c, m = expm1(alpha * e[0]), expm1(alpha * e[1]), expm1(alpha * e[2]), mu * alpha
        y = (y[0] + mu * a, y[1] + mu * b, y[2] + mu * c)
        slope = (slope[0] + m * (1.0 + a), slope[1] + m * (1.0 + b), slope[2] + m * (1.0 + c))
    mean, third = (y[0] + y[1] + y[2]) / 3.0, (slope[0] + slope[1] + slope[2]) / 9.0
    k12, k02, k01 = _shear(x, y, slope, 1, 2), _shear(x, y, slope, 0, 2), _shear(x, y, slope, 0, 1)
    a = third - (slope[1] + slope[2]) / 3.0 + k12 - (y[2] - mean)
    b = third - (slope[0] + slope[2]) / 3.0 + k02 - (y[2] - mean)
    c = third - (slope[0] + slope[1]) / 3.0 + k01 - (y[1] - mean)
    alike = (a + b + c) / 3.0
    a, b, c = abs(a - alike), abs(b - alike), abs(c - alike)
    most = max(
        slope[0] / 3.0 + third - (y[0] - mean) + b + c,
        slope[1] / 3.0 + third - (y[1] - mean) + a + c,
        slope[2] / 3.0 + third - (y[2] - mean) + a + b,
    )
    across = max(k12 * max(1.0, x[1] / x[2]), k02 * max(1.0, x[0] / x[2]), k01 * max(1.0, x[0] / x[1]))
    return max(alike, 0.0) + max(most - alike, across)


@pointwise
def _shear(x: Triple, y: Triple, slope: Triple, i: int, j: int) -> float:
    """Return the shear stiffness k_ij = λ_j² (τ_i - τ_j)/(λ_i² - λ_j²) [Pa] of the principal directions i and j, with the
    principal stretches λ and the principal Kirchhoff stresses τ. x: λ²; y: τ, up to a common value [Pa]; slope: derivatives
    of y with respect to the logarithmic strains [Pa], which give the limit for equal stretches."""
    d = x[i] / x[j] - 1.0
    return (y[i] - y[j]) / d if abs(d) > 1e-6 else 0.5 * slope[j]
