"""Radial point interpolation: radial functions and their shape functions on stencils."""

from typing import Annotated

from pellucid.approximants.radial.functions import (
    GaussianModel,
    MultiquadricModel,
    PolyharmonicModel,
    RadialModel,
    ThinPlateModel,
)
from pellucid.registry import Family, OneOf

RADIAL_FUNCTIONS = Family("radial function", RadialModel, default="polyharmonic")
AnyRadial = Annotated[RadialModel, OneOf(RADIAL_FUNCTIONS)]

RADIAL_FUNCTIONS.add(PolyharmonicModel)
RADIAL_FUNCTIONS.add(ThinPlateModel)
RADIAL_FUNCTIONS.add(MultiquadricModel)
RADIAL_FUNCTIONS.add(GaussianModel)
