"""Yeoh surface, W = G/2 (I - 3) + C₃ (I - 3)³, I = λ₁² + λ₂² + (λ₁λ₂)⁻²: neo-Hookean at small stretch, stiffer at large
stretch.

At rest K = 3G. Source: Yeoh 1990, Rubber Chem. Technol. 63, 792, without its second term; for red blood cells Dao, Li &
Suresh 2006, Mater. Sci. Eng. C 26, 1232.
"""

from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.surface_law import incompressible, invariant_excess, stretch_energy
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial
from pellucid.model import parameter


@incompressible
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


@point_function(stretch_energy, YeohSurface)
def _energy(law, a, b):
    excess = invariant_excess(a, b)
    return 0.5 * law.G * excess + law.C3 * excess * excess * excess
