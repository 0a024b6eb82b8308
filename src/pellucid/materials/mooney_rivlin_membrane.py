"""Mooney-Rivlin surface, W = G/2(1+c) (I - 3 + c (II - 3)), I = λ₁² + λ₂² + J⁻², II = λ₁⁻² + λ₂⁻² + J², J = λ₁λ₂.

c = C₂/C₁; 0 is the neo-Hookean surface. At rest K = 3G. Source: Green & Adkins 1970, Large Elastic Deformations, 2nd ed.,
chapter 4.
"""

from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.surface_law import incompressible, invariant_excess, stretch_energy
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial
from pellucid.model import parameter


@incompressible
class MooneyRivlinSurface(NamedTuple):
    """Parameters of the Mooney-Rivlin law of a surface: shear modulus G at rest [N/m], and the ratio c = C₂/C₁ of the two
    terms."""

    G: float
    ratio: float


class MooneyRivlinMembraneMaterial(SurfaceMembraneMaterial):
    """Mooney-Rivlin surface, W = G/2(1+c) (I - 3 + c (II - 3)), I = λ₁² + λ₂² + J⁻², II = λ₁⁻² + λ₂⁻² + J², J = λ₁λ₂; at
    rest K = 3G."""

    kind: Literal["mooney-rivlin-membrane"] = "mooney-rivlin-membrane"
    shear_modulus: float = parameter("N/m", "surface shear modulus G at rest", gt=0)
    invariant_ratio: float = parameter("", "ratio c = C₂/C₁ of the coefficients of the second and first invariants", ge=0)

    def elastic_law(self) -> MooneyRivlinSurface:
        return MooneyRivlinSurface(self.shear_modulus, self.invariant_ratio)


@point_function(stretch_energy, MooneyRivlinSurface)
def _energy(law, a, b):
    # II is I of the inverse stretches
    second = invariant_excess(1.0 / a, 1.0 / b)
    return 0.5 * law.G / (1.0 + law.ratio) * (invariant_excess(a, b) + law.ratio * second)
