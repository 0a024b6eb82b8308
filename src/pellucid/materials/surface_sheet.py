"""Membrane of a given thickness with a surface law: stress and wave speed follow from tensions; the material is
incompressible.

The thickness, 1/J times its value at rest, affects only the mass: stress times thickness is the tension of the law for any
thickness.
"""

from math import sqrt
from typing import NamedTuple

from pellucid.jit import point_function
from pellucid.materials.law import Law, energy
from pellucid.materials.membrane import plane_response, plane_wave_speed
from pellucid.materials.membrane_gradient import by_gradient
from pellucid.materials.surface_law import surface_energy, surface_stiffness, surface_tension
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
