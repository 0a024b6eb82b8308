"""Yeoh surface, W = G/2 (I - 3) + C₃ (I - 3)³, I = λ₁² + λ₂² + (λ₁λ₂)⁻²: neo-Hookean at small stretch, stiffer at large
stretch.

At rest K = 3G. Source: Yeoh 1990, Rubber Chem. Technol. 63, 792, without its second term; for red blood cells Dao, Li &
Suresh 2006, Mater. Sci. Eng. C 26, 1232.
"""

from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.incompressible_sheet import invariant_based, of_first_invariant
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial
from pellucid.model import parameter


@invariant_based
class YeohSurface(NamedTuple):
    """Parameters of the Yeoh law of a surface: shear modulus G at rest and coefficient C₃ of the cubic term [N/m]."""

    G: float
    C3: float


class YeohMembraneMaterial(SurfaceMembraneMaterial):
    """Yeoh surface, W = G/2 (I - 3) + C₃ (I - 3)³, I = λ₁² + λ₂² + (λ₁λ₂)⁻²; at rest K = 3G."""

    kind: Literal["yeoh-membrane"] = "yeoh-membrane"
    shear_modulus: float = parameter("N/m", "surface shear modulus G at rest", gt=0)
    cubic_coefficient: float = parameter("N/m", "coefficient C₃ of (I - 3)³", ge=0)

    def elastic_law(self) -> YeohSurface:
        return YeohSurface(self.shear_modulus, self.cubic_coefficient)

    def surface_moduli(self) -> tuple[float, float]:
        """Return the shear modulus G and the area modulus 3G at rest [N/m]."""
        return self.shear_modulus, 3.0 * self.shear_modulus


@point_function(of_first_invariant, YeohSurface)
def _of_first_invariant(law, excess):
    square = excess * excess
    half, cubic = 0.5 * law.G, law.C3
    return half * excess + cubic * square * excess, half + 3.0 * cubic * square, 6.0 * cubic * excess
