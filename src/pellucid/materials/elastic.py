"""Base classes of isotropic elastic materials, solids and membranes made of a solid, with their parameters: density, Young's
modulus, Poisson's ratio."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from math import sqrt

from pellucid.materials.law import Law
from pellucid.materials.membrane_material import SolidMembraneMaterial
from pellucid.materials.trial import MEMBRANE, Operation
from pellucid.materials.wrinkling import unwrinkled
from pellucid.model import Model, parameter


def lame(young_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Return Lamé's constants λ and μ [Pa] for Young's modulus [Pa] and Poisson's ratio."""
    mu = young_modulus / (2.0 * (1.0 + poisson_ratio))
    return 2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio), mu


class ElasticMaterial(Model):
    """Base of isotropic elastic solids and membranes."""

    density: float = parameter("kg/m^3", "initial density", gt=0)
    young_modulus: float = parameter("Pa", "Young's modulus E", gt=0)
    poisson_ratio: float = parameter("", "Poisson's ratio ν", gt=-1, lt=0.5)

    def wave_speeds(self) -> tuple[float, float]:
        """Return the speeds of plane pressure and shear waves in the initial state [m/s]."""
        lam, mu = lame(self.young_modulus, self.poisson_ratio)
        return sqrt((lam + 2.0 * mu) / self.density), sqrt(mu / self.density)


class ElasticMembraneMaterial(ElasticMaterial, SolidMembraneMaterial):
    """Base of isotropic elastic membranes given by Young's modulus and Poisson's ratio of the solid they consist of."""

    @abstractmethod
    def elastic_law(self) -> Law:
        """Return the elastic law, as a NamedTuple of its parameters for the kernels, without wrinkling: the membrane also
        carries compression."""

    def plain_law(self, thickness: float) -> Law:
        return self.elastic_law()

    def operations(self) -> Mapping[Law, Sequence[Operation]]:
        return {self.elastic_law(): (*MEMBRANE, unwrinkled) if self.wrinkling else tuple(MEMBRANE)}

    @property
    def plane_poisson_ratio(self) -> float:
        return self.poisson_ratio

    def wave_speeds(self, thickness: float = 1.0) -> tuple[float, float]:
        """Return the speeds of in-plane pressure and shear waves at the start [m/s], in plane stress: the thickness may
        change freely. They do not depend on the thickness [m]."""
        plane = self.young_modulus / (1.0 - self.poisson_ratio**2)
        return sqrt(plane / self.density), super().wave_speeds()[1]
