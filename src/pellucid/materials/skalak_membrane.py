"""Skalak's law, W = G/4 (I₁² + 2I₁ - 2I₂ + C I₂²), I₁ = λ₁² + λ₂² - 2, I₂ = (λ₁λ₂)² - 1, for red blood cells, which
conserve their area.

At rest K = (1 + 2C) G. Source: Skalak, Tözeren, Zarda & Chien 1973, Biophys. J. 13, 245, whose B is G and whose C is CG
here.
"""

from math import sqrt
from typing import Literal, NamedTuple

from pellucid.findings import Refusal
from pellucid.jit import point_function
from pellucid.materials.surface_law import stretch_energy
from pellucid.materials.surface_membrane import SurfaceMembraneMaterial
from pellucid.materials.wrinkling import natural_width
from pellucid.model import check, parameter


class SkalakSurface(NamedTuple):
    """Parameters of Skalak's law: shear modulus G [N/m], and the factor C of the resistance to a change of area."""

    G: float
    C: float


class SkalakMembraneMaterial(SurfaceMembraneMaterial):
    """Skalak's law, W = G/4 (I₁² + 2I₁ - 2I₂ + C I₂²), I₁ = λ₁² + λ₂² - 2, I₂ = (λ₁λ₂)² - 1: stiffens when stretched; the
    larger C, the larger the resistance to a change of area. At rest K = (1 + 2C) G."""

    kind: Literal["skalak-membrane"] = "skalak-membrane"
    shear_modulus: float = parameter("N/m", "surface shear modulus G", gt=0)
    area_coefficient: float = parameter("", "dimensionless area coefficient C: the area modulus is (1 + 2C) G", gt=-0.5)

    @check
    def _has_a_natural_width(self) -> None:
        if self.wrinkling and self.area_coefficient < 0.0:
            raise Refusal(
                f"area_coefficient = {self.area_coefficient:g} is below 0: a strip then widens without limit when "
                f"pulled, so wrinkling is undefined",
                "remove `wrinkling`, or set area_coefficient to 0 or more",
            )

    def elastic_law(self) -> SkalakSurface:
        return SkalakSurface(self.shear_modulus, self.area_coefficient)


@point_function(stretch_energy, SkalakSurface)
def _energy(law, a, b):
    # 2I₁ - 2I₂ is -2xy, with x = a² - 1 and y = b² - 1
    x, y = (a - 1.0) * (a + 1.0), (b - 1.0) * (b + 1.0)
    second = x + y + x * y
    return 0.25 * law.G * (x * x + y * y + law.C * second * second)


@point_function(natural_width, SkalakSurface)
def _natural_width(law, stretch):
    x = stretch * stretch
    return sqrt((1.0 + law.C * x) / (1.0 + law.C * x * x))
