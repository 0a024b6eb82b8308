"""Decoupled Mooney-Rivlin solid, W = c₁ (Ī₁-3) + c₂ (Ī₂-3) + κ/2 (J-1)², Ī₁ = J^(-2/3) tr b, Ī₂ = J^(-4/3) tr cof b.

Source: Holzapfel 2000, Nonlinear Solid Mechanics, section 6.5. With the Cayley-Hamilton theorem its isochoric Kirchhoff stress
is dev(2 c₁ b̄ - 2 c₂ b̄⁻¹). At rest μ = 2 (c₁ + c₂).
"""

from typing import Literal, NamedTuple

from pydantic import ValidationInfo, field_validator

from pellucid.jit import point_function
from pellucid.jit.elementary import power
from pellucid.materials.decoupled import (
    BulkMaterial,
    decoupled,
    isochoric_energy,
    isochoric_stiffness,
    isochoric_stress,
    linear_stiffness,
    principal_bounds,
)
from pellucid.model import parameter
from pellucid.tensors import add, cofactor, determinant, deviator, left_cauchy_green, scale, trace


@decoupled
class MooneyRivlin(NamedTuple):
    """Parameters of the Mooney-Rivlin law: coefficients c₁, c₂ and bulk modulus [Pa], initial density [kg/m³]."""

    c1: float
    c2: float
    kappa: float
    rho0: float


class MooneyRivlinMaterial(BulkMaterial):
    """Mooney-Rivlin solid, W = c₁ (Ī₁ - 3) + c₂ (Ī₂ - 3) + κ/2 (J-1)²: any strain; at rest μ = 2 (c₁ + c₂)."""

    kind: Literal["mooney-rivlin"] = "mooney-rivlin"
    c1: float = parameter("Pa", "coefficient c₁ of the first invariant", ge=0)
    c2: float = parameter("Pa", "coefficient c₂ of the second invariant", ge=0)

    @field_validator("c2")
    @classmethod
    def _resists_shear(cls, c2: float, info: ValidationInfo) -> float:
        if c2 == 0.0 == info.data.get("c1"):
            raise ValueError("c1 = 0 and c2 = 0: the shear modulus 2 (c1 + c2) must be above 0")
        return c2

    def moduli(self) -> tuple[float, float]:
        return 2.0 * (self.c1 + self.c2), self.bulk_modulus

    def law(self) -> MooneyRivlin:
        return MooneyRivlin(self.c1, self.c2, self.bulk_modulus, self.density)


@point_function(isochoric_energy, MooneyRivlin)
def _isochoric_energy(law, F):
    J = determinant(F)
    first = power(J, -2.0 / 3.0) * trace(left_cauchy_green(F))
    second = power(J, -4.0 / 3.0) * trace(left_cauchy_green(cofactor(F)))
    return law.c1 * (first - 3.0) + law.c2 * (second - 3.0)


@point_function(isochoric_stress, MooneyRivlin)
def _isochoric_stress(law, F):
    J = determinant(F)
    first = scale(2.0 * law.c1 * power(J, -2.0 / 3.0), deviator(left_cauchy_green(F)))
    second = scale(-2.0 * law.c2 * power(J, -4.0 / 3.0), deviator(left_cauchy_green(cofactor(F))))
    return add(first, second)


@point_function(isochoric_stiffness, MooneyRivlin)
def _isochoric_stiffness(law, F):
    # along m = a n + s e, e across n, with B = b̄⁻¹: d²Ī₂/dε² = 2 (m·Bm + 2/3 a n·Bm - a²/9 tr B)
    J, b, B = determinant(F), left_cauchy_green(F), left_cauchy_green(cofactor(F))
    high, low = principal_bounds(b)
    first = linear_stiffness(high, low, trace(b))
    high, low = principal_bounds(B)
    second = max(5.0 / 3.0 * high - trace(B) / 9.0, high) + 2.0 / 3.0 * (high - low)
    return 2.0 * law.c1 * power(J, -2.0 / 3.0) * first + 2.0 * law.c2 * power(J, -4.0 / 3.0) * second
