"""Parameters of membranes by a surface law: moduli of the surface [N/m], and a thickness that serves mass alone."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from math import sqrt

from pellucid.materials.law import Law
from pellucid.materials.solid_membrane import SolidMembraneMaterial
from pellucid.materials.surface_law import stretch_curvatures, stretch_energy, stretch_slopes
from pellucid.materials.surface_sheet import SurfaceSheet
from pellucid.materials.trial import Operation


class SurfaceMembraneMaterial(SolidMembraneMaterial):
    """Base of membranes with a surface law."""

    @abstractmethod
    def elastic_law(self) -> Law:
        """The surface law as kernels take it."""

    @abstractmethod
    def surface_moduli(self) -> tuple[float, float]:
        """Shear and area modulus at rest [N/m], along the stiffest direction where it has directions."""

    def plain_law(self, thickness: float) -> SurfaceSheet:
        return SurfaceSheet(self.elastic_law(), thickness)

    def operations(self) -> Mapping[Law, Sequence[Operation]]:
        return {self.elastic_law(): (stretch_energy, stretch_slopes, stretch_curvatures)}

    def wave_speeds(self, thickness: float = 1.0) -> tuple[float, float]:
        """Return the speeds of in-plane pressure and shear waves of a membrane of this thickness [m] at the start [m/s]."""
        shear, area = self.surface_moduli()
        areal_density = self.density * thickness
        return sqrt((area + shear) / areal_density), sqrt(shear / areal_density)
