"""Evans and Skalak's law, W = K/2 (J - 1)² + G ((λ₁² + λ₂²)/2J - 1), J = λ₁λ₂: separate area and shear terms.

Source: Evans & Skalak 1980, Mechanics and Thermodynamics of Biomembranes, section 4.
"""

from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.surface_law import stretch_curvatures, stretch_energy, stretch_slopes
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

    def surface_moduli(self) -> tuple[float, float]:
        """Return the shear modulus G and the area modulus K at rest [N/m]."""
        return self.shear_modulus, self.area_modulus


@point_function(stretch_energy, EvansSkalakSurface)
def _energy(law, a, b):
    J = a * b
    return 0.5 * law.K * (J - 1.0) * (J - 1.0) + 0.5 * law.G * (a - b) * (a - b) / J


@point_function(stretch_slopes, EvansSkalakSurface)
def _slopes(law, a, b):
    J = a * b
    even, apart = law.K * (J - 1.0), 0.5 * law.G * (a - b) * (a + b) / J
    return b * even + apart / a, a * even - apart / b


@point_function(stretch_curvatures, EvansSkalakSurface)
def _curvatures(law, a, b):
    x, y = a * a, b * b
    mixed = law.K * (2.0 * a * b - 1.0) - 0.5 * law.G * (1.0 / x + 1.0 / y)
    return law.K * y + law.G * b / (a * x), law.K * x + law.G * a / (b * y), mixed
