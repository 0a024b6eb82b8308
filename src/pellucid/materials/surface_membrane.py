"""Parameters of membranes with a surface law: surface moduli [N/m]; and the sheet of a given thickness that such a law
becomes.

The thickness, 1/J times its value at rest (the material is incompressible), affects only the mass: stress times thickness is
the tension of the law for any thickness.
"""

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from math import sqrt
from typing import NamedTuple

from pellucid.jit import point_function
from pellucid.materials.law import Law, energy
from pellucid.materials.membrane import plane_response, plane_wave_speed
from pellucid.materials.membrane_gradient import by_gradient
from pellucid.materials.membrane_material import SolidMembraneMaterial
from pellucid.materials.surface_law import (
    stretch_curvatures,
    stretch_energy,
    stretch_slopes,
    surface_energy,
    surface_stiffness,
    surface_tension,
)
from pellucid.materials.trial import Operation
from pellucid.materials.wrinkling import natural_width


@by_gradient
class SurfaceSheet(NamedTuple):
    """Parameters of a membrane with a surface law and a thickness: the surface law, and the thickness at rest [m]."""

    law: Law
    thickness: float


@point_function(plane_response, SurfaceSheet)
def _plane_response(law, shape):
    t11, t22, t12 = surface_tension(law.law, shape)
    inverse = 1.0 / law.thickness
    return inverse * t11, inverse * t22, inverse * t12, 1.0 / (shape[0] * shape[3] - shape[1] * shape[2])


@point_function(energy, SurfaceSheet)
def _energy(law, F):
    return surface_energy(law.law, F) / law.thickness


@point_function(plane_wave_speed, SurfaceSheet)
def _plane_wave_speed(law, shape, density):
    # the density stays that at rest, and density times thickness is the mass of unit initial area
    return sqrt(surface_stiffness(law.law, shape) / (law.thickness * density))


@point_function(natural_width, SurfaceSheet)
def _natural_width(law, stretch):
    return natural_width(law.law, stretch)


class SurfaceMembraneMaterial(SolidMembraneMaterial):
    """Base of the materials of membranes with a surface law: moduli in N/m, independent of the thickness."""

    @abstractmethod
    def elastic_law(self) -> Law:
        """Return the surface law (see `pellucid.materials.surface_law`), as a NamedTuple of its parameters for the kernels."""

    def surface_moduli(self) -> tuple[float, float]:
        """Return the surface shear and area moduli at rest [N/m]; for anisotropic laws along the stiffest direction."""
        along, _, across = stretch_curvatures(self.elastic_law(), 1.0, 1.0)
        return 0.5 * (along - across), 0.5 * (along + across)

    def moduli_at_rest(self) -> Mapping[str, float]:
        return dict(zip(("shear modulus", "area modulus"), self.surface_moduli(), strict=True))

    def plain_law(self, thickness: float) -> SurfaceSheet:
        return SurfaceSheet(self.elastic_law(), thickness)

    def operations(self) -> Mapping[Law, Sequence[Operation]]:
        return {self.elastic_law(): (stretch_energy, stretch_slopes, stretch_curvatures)}

    def wave_speeds(self, thickness: float = 1.0) -> tuple[float, float]:
        """Return the speeds of in-plane pressure and shear waves of a membrane of this thickness [m] at the start [m/s]."""
        shear, area = self.surface_moduli()
        areal_density = self.density * thickness
        return sqrt((area + shear) / areal_density), sqrt(shear / areal_density)
