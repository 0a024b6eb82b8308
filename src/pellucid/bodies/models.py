"""List of the kinds of bodies that a case can name: one line each."""

from typing import Annotated

from pellucid.bodies.diffusing_field.model import DiffusingFieldCase
from pellucid.bodies.fluid_film.model import FluidFilmCase
from pellucid.bodies.material_points.model import MaterialPointsCase
from pellucid.bodies.membrane_elements.model import MembraneElementsCase
from pellucid.bodies.membrane_points.model import MembranePointsCase
from pellucid.bodies.meshless_solid.model import MeshlessSolidCase
from pellucid.parts.body_model import BodyModel
from pellucid.registry import Family, OneOf

BODIES = Family("body", BodyModel, default="material-points")
Body = Annotated[BodyModel, OneOf(BODIES)]

BODIES.add(MaterialPointsCase)
BODIES.add(MembranePointsCase)
BODIES.add(MembraneElementsCase)
BODIES.add(MeshlessSolidCase)
BODIES.add(FluidFilmCase)
BODIES.add(DiffusingFieldCase)
