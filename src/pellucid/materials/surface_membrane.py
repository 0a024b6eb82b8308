"""Parameters of membranes with a surface law: surface moduli [N/m]; the thickness affects only the mass."""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from math import sqrt

from pellucid.materials.law import Law
from pellucid.materials.solid_membrane import SolidMembraneMaterial
from pellucid.materials.surface_law import stretch_curvatures, stretch_energy, stretch_slopes
from pellucid.materials.surface_sheet import SurfaceSheet
from pellucid.materials.trial import Operation


class SurfaceMembraneMaterial(SolidMembraneMaterial):
    """Base of the materials of membranes with a surface law: moduli in N/m, independent of the thickness."""

    @abstractmethod
    def elastic_law(self) -> Law:
        """Return the surface law (see `pellucid.materials.surface_law`), as a NamedTuple of its parameters for the kernels."""

    def surface_moduli(self) -> tuple[float, float]:
        """Return the surface shear and area moduli at rest [N/m]; for anisotropic laws along the stiffest direction."""
        along, _, across = stretch_curvatures(self.elastic_law(), 1.0, 1.0)
        return 0.5 * (along - across), 0.5 * (along + across)

    def plain_law(self, thickness: float) -> SurfaceSheet:
        return SurfaceSheet(self.elastic_law(), thickness)

    def operations(self) -> Mapping[Law, Sequence[Operation]]:
        return {self.elastic_law(): (stretch_energy, stretch_slopes, stretch_curvatures)}

    def wave_speeds(self, thickness: float = 1.0) -> tuple[float, float]:
        """Return the speeds of in-plane pressure and shear waves of a membrane of this thickness [m] at the start [m/s]."""
        shear, area = self.surface_moduli()
        areal_density = self.density * thickness
        return sqrt((area + shear) / areal_density), sqrt(shear / areal_density)
