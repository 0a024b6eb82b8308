"""Settings that all kinds of membranes share in a case file, and their checks."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar

import numpy as np

from pellucid.bodies.damped_model import DampedModel
from pellucid.bodies.initial import INITIAL_MEANING, Initial, initial_problems, initial_velocity, plane_velocity_problems
from pellucid.bodies.membranes.prestretch import prestretch
from pellucid.findings import Finding, Path, Reason
from pellucid.geometry.region import Selectable
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.surfaces.surface import Inside, Surface
from pellucid.grid.model import GridCase
from pellucid.materials.membrane import plane_diffusivity, wave_in_shape
from pellucid.materials.membrane_material import MembraneMaterial, SolidMembraneMaterial
from pellucid.model import Vector, parameter
from pellucid.parts.part import Parts

NEEDS_SPACE = "needs a grid that is more than one cell thick along every axis"
TINY = 1e-300
ACROSS = 1e-4  # difference from 1 of the cosine of an angle of 0.8° between a direction and the normal
CLOSE_IT = "use a surface that encloses a volume; for a file of a closed surface set `closed = true`"


class MembraneCase(DampedModel):
    """Base class of the settings of membranes: initial surface, thickness, tension, velocity."""

    place: ClassVar[str] = "surface"
    start_only: ClassVar[tuple[str, ...]] = (*DampedModel.start_only, "thickness", "tension", "inflation")
    is_surface: ClassVar[bool] = True

    surface: Surface = parameter("", "initial surface of the membrane")
    thickness: float = parameter("m", "initial thickness, half of it on each side of `surface`", gt=0)
    contact_offset: float | None = parameter(
        "m",
        "distance from `surface` at which other bodies and walls touch the membrane, on either side; 0: at `surface` itself. "
        "Default: half of `thickness`",
        None,
        ge=0,
    )
    if TYPE_CHECKING:  # each kind declares its own
        material: MembraneMaterial
    tension: float = parameter(
        "N/m", "initial isotropic tension; `thickness` and `density` are the values under this tension", 0.0, ge=0
    )
    inflation: float = parameter(
        "",
        "alternative to `tension`: initial isotropic stretch 1 + α relative to the rest state",
        0.0,
        ge=0,
    )
    velocity: Vector = parameter("m/s", "initial velocity", (0.0, 0.0, 0.0))
    initial: tuple[Initial, ...] = parameter("", INITIAL_MEANING, ())

    @property
    def contact_reach(self) -> float:
        """Distance from the mid-surface at which contact with other bodies begins [m]."""
        return 0.5 * self.thickness if self.contact_offset is None else self.contact_offset

    def occupied(self) -> Geometry:
        return Inside(surface=self.surface)

    @property
    def has_triangles(self) -> bool:
        return True

    def selectable(self) -> Selectable:
        return Selectable.of_membrane(*self.surface.triangulate(), self.surface.sets())

    def why_not_excluded(self, grid: GridCase | None) -> Reason | None:
        """Return a reason why other bodies cannot exclude the region inside the membrane: its surface is open, or the grid is
        one cell thick along an axis; None if they can.
        """
        if grid is not None and any(grid.thin()):
            return Reason(f"the inside of a surface {NEEDS_SPACE}", "remove this name, or enlarge the grid")
        if not self.surface.closed:
            text = f"the surface of membrane {self.name} is open: it has no inside that could be excluded"
            return Reason(text, f"name bodies of material points and closed membranes; {CLOSE_IT}")
        return None

    def initial_velocity(self, position: np.ndarray) -> np.ndarray:
        return initial_velocity(self.velocity, self.name, self.initial, position)

    def signals_at_start(self) -> tuple[float, float]:
        """Return the speed of in-plane waves [m/s] and the kinematic viscosity [m²/s] of the membrane under its initial
        tension."""
        density, tense = self.material.density, prestretch(self.material.law, self.tension, self.thickness, self.inflation)
        return wave_in_shape(tense.law, tense.shape, density), plane_diffusivity(tense.law, tense.shape, density)

    def waves_at_start(self) -> tuple[float, float]:
        return self.material.wave_speeds(self.thickness)

    def losses(self) -> tuple[str, ...]:
        """Names of the fields of the results that contain energy dissipated by viscosity."""
        material = self.material
        return ("dissipated_energy",) if isinstance(material, SolidMembraneMaterial) and material.is_viscous else ()

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings (errors of the case) for initial fields, fibre directions and initial tensions that a membrane cannot
        have.

        path: path of the body in the data of the case; parts: all parts of the case.
        """
        yield from super().problems(path, parts)
        yield from initial_problems(self.initial, ("velocity",), path)
        yield from plane_velocity_problems(self, path, parts)
        material = self.material
        if material.direction is not None:
            yield from self._direction_problems((*path, "material"), material.direction)
        key = "inflation" if self.inflation else "tension"
        if self.inflation > 0.0 and self.tension > 0.0:
            yield Finding((*path, key), "`tension` already defines the stretch of the membrane", "remove one of them")
        elif self.tension > 0.0 and material.direction is not None:
            text = "a membrane with fibres has no isotropic stretch with isotropic tension"
            yield Finding((*path, "tension"), text, "remove it, and stretch the membrane by prescribed motions of its rim")
        elif self.tension + self.inflation > 0.0 and not isinstance(material, SolidMembraneMaterial):
            text = f'a membrane of kind "{material.kind}" has no elastic tension'
            yield Finding((*path, key), text, "remove it, or use an elastic material")
        elif self.tension + self.inflation > 0.0:
            try:
                prestretch(material.law, self.tension, self.thickness, self.inflation)
            except ValueError as error:
                yield Finding((*path, key), str(error), f"use a smaller {key}, or a stiffer or thicker membrane")

    def _direction_problems(self, path: Path, direction: np.ndarray) -> Iterator[Finding]:
        """Yield a finding (an error of the case) if the material direction is normal to the surface somewhere, so that it has
        no projection there. path: path of the body in the data of the case; direction: shape (3,).
        """
        vertices, triangles = self.surface.triangulate()
        corners = vertices[triangles]
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        length = np.linalg.norm(normal, axis=1)
        across = np.abs(normal @ direction) / np.maximum(length * np.linalg.norm(direction), TINY)
        worst = int(np.argmax(across))
        if across[worst] > 1.0 - ACROSS:
            place = ", ".join(f"{x:.4g}" for x in corners[worst].mean(axis=0))
            text = (
                f"fibre_direction is normal to the surface at ({place}) m, so the "
                "direction of the fibres at this point is undefined"
            )
            yield Finding(path, text, "choose a direction that is nowhere normal to the surface, such as the axis of a tube")
