"""Evans and Skalak's law, W = K/2 (J - 1)² + G ((λ₁² + λ₂²)/2J - 1), J = λ₁λ₂: separate area and shear terms.

Source: Evans & Skalak 1980, Mechanics and Thermodynamics of Biomembranes, section 4.
"""

from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.surface_law import stretch_energy
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial
from pellucid.model import parameter


class EvansSkalakSurface(NamedTuple):
    """Parameters of Evans and Skalak's law: area modulus K and shear modulus G [N/m]."""

    K: float
    G: float


class EvansSkalakMembraneMaterial(SurfaceMembraneMaterial):
    """Evans and Skalak's law, W = K/2 (J - 1)² + G ((λ₁² + λ₂²)/2J - 1), J = λ₁λ₂: separate area and shear terms. Without a
    shear modulus it describes a vesicle that resists only a change of its area."""

    kind: Literal["evans-skalak-membrane"] = "evans-skalak-membrane"
    area_modulus: float = parameter("N/m", "surface area modulus K", gt=0)
    shear_modulus: float = parameter("N/m", "surface shear modulus G", ge=0)

    def elastic_law(self) -> EvansSkalakSurface:
        return EvansSkalakSurface(self.area_modulus, self.shear_modulus)


@point_function(stretch_energy, EvansSkalakSurface)
def _energy(law, a, b):
    J = a * b
    return 0.5 * law.K * (J - 1.0) * (J - 1.0) + 0.5 * law.G * (a - b) * (a - b) / J
