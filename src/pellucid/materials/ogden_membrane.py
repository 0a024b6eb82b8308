"""Ogden surface, W = Σ_p m_p/α_p (λ₁^α_p + λ₂^α_p + (λ₁λ₂)^(-α_p) - 3): an incompressible rubber sheet with several terms.

At rest G = ½ Σ m_p α_p and K = 3G. Source: Ogden 1972, Proc. R. Soc. Lond. A 326, 565. All functions use `expm1` of
logarithmic strains, which is accurate at small strains.
"""

from typing import Literal, NamedTuple

from pydantic import ValidationInfo, field_validator

from pellucid.jit import point_function
from pellucid.jit.elementary import expm1, log
from pellucid.materials.ogden import check_terms
from pellucid.materials.surface_law import incompressible, stretch_curvatures, stretch_energy, stretch_slopes
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial
from pellucid.model import parameter


@incompressible
class OgdenSurface(NamedTuple):
    """Parameters of the Ogden law of a surface: moduli m_p [N/m] and exponents α_p of the terms."""

    moduli: tuple[float, ...]
    exponents: tuple[float, ...]


class OgdenMembraneMaterial(SurfaceMembraneMaterial):
    """Ogden surface, W = Σ m_p/α_p (λ₁^α_p + λ₂^α_p + (λ₁λ₂)^(-α_p) - 3); at rest G = ½ Σ m_p α_p and K = 3G."""

    kind: Literal["ogden-membrane"] = "ogden-membrane"
    shear_moduli: tuple[float, ...] = parameter(
        "N/m", "moduli m_p of the terms, each with the sign of its exponent", min_length=1
    )
    exponents: tuple[float, ...] = parameter("", "exponents α_p of the terms", min_length=1)

    @field_validator("exponents")
    @classmethod
    def _terms_resist(cls, exponents: tuple[float, ...], info: ValidationInfo) -> tuple[float, ...]:
        check_terms(info.data.get("shear_moduli", ()), exponents)
        return exponents

    def elastic_law(self) -> OgdenSurface:
        return OgdenSurface(self.shear_moduli, self.exponents)


@point_function(stretch_energy, OgdenSurface)
def _energy(law, a, b):
    one, two, total = log(a), log(b), 0.0
    for p in range(len(law.moduli)):
        m, alpha = law.moduli[p], law.exponents[p]
        total += m / alpha * (expm1(alpha * one) + expm1(alpha * two) + expm1(-alpha * (one + two)))
    return total


@point_function(stretch_slopes, OgdenSurface)
def _slopes(law, a, b):
    one, two, first, second = log(a), log(b), 0.0, 0.0
    for p in range(len(law.moduli)):
        m, alpha = law.moduli[p], law.exponents[p]
        third = expm1(-alpha * (one + two))
        first += m * (expm1(alpha * one) - third)
        second += m * (expm1(alpha * two) - third)
    return first / a, second / b


@point_function(stretch_curvatures, OgdenSurface)
def _curvatures(law, a, b):
    one, two, first, second, mixed = log(a), log(b), 0.0, 0.0, 0.0
    for p in range(len(law.moduli)):
        m, alpha = law.moduli[p], law.exponents[p]
        third = 1.0 + expm1(-alpha * (one + two))
        first += m * ((alpha - 1.0) * (1.0 + expm1(alpha * one)) + (alpha + 1.0) * third)
        second += m * ((alpha - 1.0) * (1.0 + expm1(alpha * two)) + (alpha + 1.0) * third)
        mixed += m * alpha * third
    return first / (a * a), second / (b * b), mixed / (a * b)
