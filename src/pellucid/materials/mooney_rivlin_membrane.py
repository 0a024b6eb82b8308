"""Mooney-Rivlin surface, W = G/2(1+c) (I - 3 + c (II - 3)), I = λ₁² + λ₂² + J⁻², II = λ₁⁻² + λ₂⁻² + J², J = λ₁λ₂.

c = C₂/C₁; 0 is the neo-Hookean surface. At rest K = 3G. Source: Green & Adkins 1970, Large Elastic Deformations, 2nd ed.,
chapter 4.
"""

from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.incompressible_sheet import incompressible, invariant_curvatures, invariant_excess, invariant_slopes
from pellucid.materials.surface_law import stretch_curvatures, stretch_energy, stretch_slopes
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

    def surface_moduli(self) -> tuple[float, float]:
        """Return the shear modulus G and the area modulus 3G at rest [N/m]."""
        return self.shear_modulus, 3.0 * self.shear_modulus


@point_function(stretch_energy, MooneyRivlinSurface)
def _energy(law, a, b):
    # II is I of the inverse stretches
    second = invariant_excess(1.0 / a, 1.0 / b)
    return 0.5 * law.G / (1.0 + law.ratio) * (invariant_excess(a, b) + law.ratio * second)


@point_function(stretch_slopes, MooneyRivlinSurface)
def _slopes(law, a, b):
    one, two = invariant_slopes(a, b)
    first, c = 0.5 * law.G / (1.0 + law.ratio), law.ratio
    return (
        first * (one + 2.0 * c * (a * b * b - 1.0 / (a * a * a))),
        first * (two + 2.0 * c * (b * a * a - 1.0 / (b * b * b))),
    )


@point_function(stretch_curvatures, MooneyRivlinSurface)
def _curvatures(law, a, b):
    one, two, mixed = invariant_curvatures(a, b)
    first, c = 0.5 * law.G / (1.0 + law.ratio), law.ratio
    x, y = a * a, b * b
    return (
        first * (one + c * (2.0 * y + 6.0 / (x * x))),
        first * (two + c * (2.0 * x + 6.0 / (y * y))),
        first * (mixed + 4.0 * c * a * b),
    )
