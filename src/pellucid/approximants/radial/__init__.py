"""Radial point interpolation: radial functions, one file each, and their shape functions on stencils."""

from typing import Annotated

from pellucid.approximants.radial.contract import RadialModel
from pellucid.approximants.radial.gaussian import GaussianModel
from pellucid.approximants.radial.multiquadric import MultiquadricModel
from pellucid.approximants.radial.polyharmonic import PolyharmonicModel
from pellucid.approximants.radial.thin_plate import ThinPlateModel
from pellucid.registry import Family, OneOf

RADIAL_FUNCTIONS = Family("radial function", RadialModel, default="polyharmonic")
AnyRadial = Annotated[RadialModel, OneOf(RADIAL_FUNCTIONS)]

RADIAL_FUNCTIONS.add(PolyharmonicModel)
RADIAL_FUNCTIONS.add(ThinPlateModel)
RADIAL_FUNCTIONS.add(MultiquadricModel)
RADIAL_FUNCTIONS.add(GaussianModel)
