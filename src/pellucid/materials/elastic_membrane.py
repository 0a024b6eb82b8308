"""Parameters of isotropic elastic membranes made of a solid: Young's modulus and Poisson's ratio."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from math import sqrt

from pellucid.materials.elastic import ElasticMaterial
from pellucid.materials.law import Law
from pellucid.materials.solid_membrane import SolidMembraneMaterial
from pellucid.materials.trial import MEMBRANE, Operation
from pellucid.materials.wrinkling import unwrinkled


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
