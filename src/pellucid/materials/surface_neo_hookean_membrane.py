"""Neo-Hookean surface, W = G/2 (λ₁² + λ₂² + (λ₁λ₂)⁻² - 3): an incompressible rubber sheet with the surface modulus G = μh,
for the shear modulus μ and the thickness h.

At rest the area modulus is K = 3G. Source: Barthès-Biesel, Diaz & Dhenin 2002, J. Fluid Mech. 460, 211.
"""

from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.surface_law import incompressible, invariant_excess, stretch_energy
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial
from pellucid.model import parameter


@incompressible
class SurfaceNeoHookean(NamedTuple):
    """Parameter of the neo-Hookean law of a surface: shear modulus G at rest [N/m]."""

    G: float


class SurfaceNeoHookeanMembraneMaterial(SurfaceMembraneMaterial):
    """Neo-Hookean surface, W = G/2 (λ₁² + λ₂² + (λ₁λ₂)⁻² - 3); at rest K = 3G."""

    kind: Literal["surface-neo-hookean-membrane"] = "surface-neo-hookean-membrane"
    shear_modulus: float = parameter("N/m", "surface shear modulus G, a third of the surface Young's modulus", gt=0)

    def elastic_law(self) -> SurfaceNeoHookean:
        return SurfaceNeoHookean(self.shear_modulus)


@point_function(stretch_energy, SurfaceNeoHookean)
def _energy(law, a, b):
    return 0.5 * law.G * invariant_excess(a, b)
