"""Decoupled Mooney-Rivlin solid, W = c₁ (Ī₁-3) + c₂ (Ī₂-3) + κ/2 (J-1)², Ī₁ = J^(-2/3) tr b, Ī₂ = J^(-4/3) tr cof b.

Source: Holzapfel 2000, Nonlinear Solid Mechanics, section 6.5. With the Cayley-Hamilton theorem its isochoric Kirchhoff stress
is dev(2 c₁ b̄ - 2 c₂ b̄⁻¹). At rest μ = 2 (c₁ + c₂).
"""

from typing import Literal, NamedTuple

from pydantic import ValidationInfo, field_validator

from pellucid.jit import point_function
from pellucid.materials.decoupled import BulkMaterial, decoupled
from pellucid.materials.law import invariant_energy
from pellucid.model import parameter


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

    def law(self) -> MooneyRivlin:
        return MooneyRivlin(self.c1, self.c2, self.bulk_modulus, self.density)


@point_function(invariant_energy, MooneyRivlin)
def _energy(law, first, second):
    return law.c1 * first + law.c2 * second
