"""The keys that all kinds of membranes share, as the user describes them."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from pellucid.bodies.damped_model import DampedModel
from pellucid.bodies.initial import INITIAL_MEANING, Initial
from pellucid.bodies.initial.state import initial_problems, initial_velocity
from pellucid.bodies.membranes.prestretch import prestretch
from pellucid.findings import Finding, Path, Reason
from pellucid.geometry.region import Selectable
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.surfaces.inside import Inside
from pellucid.geometry.surfaces.surface import Surface
from pellucid.grid.model import GridCase
from pellucid.materials.elastic_membrane import ElasticMembraneMaterial
from pellucid.materials.membrane import plane_diffusivity, wave_in_shape
from pellucid.materials.membrane_material import MembraneMaterial
from pellucid.model import Vector, parameter
from pellucid.parts.part import Parts

NEEDS_SPACE = "needs a grid that is more than one cell thick along every axis"
CLOSE_IT = "use a surface that encloses a volume; a file that does says `closed = true`"


class MembraneCase(DampedModel):
    """A membrane on a surface."""

    place: ClassVar[str] = "surface"
    start_only: ClassVar[tuple[str, ...]] = (*DampedModel.start_only, "thickness", "tension")
    is_surface: ClassVar[bool] = True

    surface: Surface = parameter("", "where the membrane is at the start")
    thickness: float = parameter("m", "initial thickness", gt=0)
    if TYPE_CHECKING:  # each kind declares its own
        material: MembraneMaterial
    tension: float = parameter(
        "N/m", "initial tension along all directions; thickness and density are those of the tense membrane", 0.0, ge=0
    )
    velocity: Vector = parameter("m/s", "initial velocity", (0.0, 0.0, 0.0))
    initial: tuple[Initial, ...] = parameter("", INITIAL_MEANING, ())

    def occupied(self) -> Geometry:
        """The region that the membrane encloses."""
        return Inside(surface=self.surface)

    def selectable(self) -> Selectable:
        """Its nodes or points, its elements in triangles, its rim, the sets of its file."""
        return Selectable.of_membrane(*self.surface.triangulate(), self.surface.sets())

    def why_not_excluded(self, grid: GridCase | None) -> Reason | None:
        """A surface that is open, or flat, has no inside."""
        if grid is not None and any(grid.thin()):
            return Reason(f"the inside of a surface {NEEDS_SPACE}", "leave this name out, or enlarge the grid")
        if not self.surface.closed:
            text = f"the surface of membrane {self.name} is open: it has no inside that could be left out"
            return Reason(text, f"name bodies of material points and closed membranes; {CLOSE_IT}")
        return None

    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        """Velocities at the start [m/s], shape (n, 3), at positions [m], shape (n, 3)."""
        return initial_velocity(self.velocity, self.name, self.initial, position)

    def signals_at_start(self) -> tuple[float, float]:
        """Speed of waves in its plane [m/s] and kinematic viscosity [m²/s] under its tension at the start."""
        law, density = self.material.law(), self.material.density
        shape = prestretch(law, self.tension, self.thickness).shape
        return wave_in_shape(law, shape, density), plane_diffusivity(law, shape, density)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Findings of initial fields that a membrane cannot have."""
        yield from super().problems(path, parts)
        yield from initial_problems(self.initial, ("velocity",), path)
        material = self.material
        if self.tension > 0.0 and not isinstance(material, ElasticMembraneMaterial):
            text = f'a membrane of kind "{material.kind}" has no elastic tension'
            yield Finding((*path, "tension"), text, "leave it out, or use an elastic material")
        elif self.tension > 0.0 and isinstance(material, ElasticMembraneMaterial):
            try:
                prestretch(material.law(), self.tension, self.thickness)
            except ValueError as error:
                yield Finding((*path, "tension"), str(error), "use a smaller tension, or a stiffer or thicker membrane")
