"""Data model of walls: planes without a body."""

from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any, ClassVar

import numpy as np
from pydantic import field_validator, model_validator

from pellucid.conditions.contact import Sliding
from pellucid.contact.wall_plane import WallPlane
from pellucid.energy import CONTACT_WORK, Channel
from pellucid.findings import Finding, Path, Reason, Refusal
from pellucid.grid.model import GridCase
from pellucid.model import Vector, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import is_driven
from pellucid.parts.part import Parts
from pellucid.units import in_degrees

ON_A_FACE = 1e-9  # tolerance for a plane on a face of the grid, in cells
OF_OTHER_WALLS = ("surface", "shape", "where")  # keys that users give for walls that are not planes
CURVED = (
    "for a channel of fluids with a wall from a file use a [[support]] with "
    'where = { outside = { surface = { file = { path = "...", closed = true } } } }, for an obstacle a shape, such as '
    "where = { sphere = { ... } }; for other bodies use a fixed body"
)


class Wall(Sliding):
    """A rigid plane that bodies cannot penetrate, without a body of its own. It extends across the whole grid."""

    losses: ClassVar[Sequence[Channel]] = (CONTACT_WORK,)  # energy that bodies lose at the wall

    point: Vector = parameter("m", "a point of the plane at time 0")
    normal: Vector = parameter("", "normal of the plane, of any length, towards the bodies")
    velocity: Vector = parameter(
        "m/s",
        "velocity of the wall: the normal component moves the plane, the tangential component drags bodies by friction",
        (0, 0, 0),
    )
    bodies: tuple[str, ...] = parameter(
        "", "bodies in contact with this wall; default: all bodies except those whose motion is fully prescribed", ()
    )

    contact_angle: float | None = parameter(
        "",
        "contact angle of fluids with surface tension, measured within the fluid, in degrees, or a text with a unit; "
        "default: the contact angle of the fluid",
        None,
        ge=0,
        le=180,
    )

    _in_degrees = field_validator("contact_angle", mode="before")(in_degrees)

    @model_validator(mode="before")
    @classmethod
    def _is_a_plane(cls, data: Any) -> Any:
        if isinstance(data, dict) and (other := next((key for key in OF_OTHER_WALLS if key in data), None)):
            raise Refusal(f"a [[wall]] is a plane and has no `{other}`", CURVED)
        return data

    @property
    def advances(self) -> bool:
        """True if the wall moves along its normal."""
        return sum(a * b for a, b in zip(self.normal, self.velocity, strict=True)) != 0.0

    @field_validator("normal")
    @classmethod
    def _points_somewhere(cls, normal: Vector) -> Vector:
        if not any(normal):
            raise ValueError("the normal is zero; it must point towards the bodies, such as [0, 1, 0]")
        return normal

    def plane(self) -> WallPlane:
        """Return the plane of the wall at time 0."""
        return WallPlane(self.point, self.normal, self.velocity)

    def touching(self, bodies: Sequence[BodyModel]) -> list[BodyModel]:
        """Return the bodies on which the wall can act: those that its key `bodies` lists, or else all bodies that can have
        contact with walls."""
        return [body for body in bodies if body.name in self.bodies or not (self.bodies or why_no_wall(body))]

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a wall whose plane does not fit the grid, and bodies that cannot have contact with walls.
        path: location of the condition in the case; parts: all parts of the case."""
        yield from parts.no_grid((*path, "point"), "contact with walls needs a grid")
        if parts.grid is not None:
            yield from self._grid_problems(path, parts.grid)
        yield from self._body_problems(path, parts)
        if self.contact_angle is not None and not parts.sections["surface_tension"].items:
            text = "no fluid in this case has surface tension"
            remedy = "add a [[surface_tension]] with the name of a fluid as `body`, or remove the contact angle"
            yield Finding((*path, "contact_angle"), text, remedy)
        elif self.contact_angle is not None and self.advances:
            text = "the wall moves along its normal: the energy of a surface on it is unknown"
            yield Finding((*path, "contact_angle"), text, "remove the contact angle, or move the wall along its plane only")
        yield from super().problems(path, parts)

    def _grid_problems(self, path: Path, grid: GridCase) -> Iterator[Finding]:
        for key in ("normal", "velocity"):
            for axis, component, thin in zip("xyz", getattr(self, key), grid.thin(), strict=True):
                if thin and component != 0.0:
                    text = f"has the component {component:g} along {axis}, along which the grid is one cell thick"
                    yield Finding((*path, key), text, f"set its {axis} component to 0: nothing moves along {axis}")
                    return
        for axis, component in zip("xyz", self.normal, strict=True):
            if axis in grid.periodic and component != 0.0:
                text = (
                    f"has the component {component:g} along {axis}, along which the grid is periodic: the plane "
                    "would end at the seam"
                )
                yield Finding((*path, "normal"), text, f"set its {axis} component to 0, or remove {axis} from grid.periodic")
                return
        corners = np.array(list(product(*zip(grid.lower, grid.extent_upper(), strict=True))))
        height, slack = self.plane().height(corners), ON_A_FACE * grid.cell
        if height.min() > slack or height.max() < -slack:
            side, by = ("before", height.min()) if height.min() > 0.0 else ("behind", -height.max())
            low, high = (", ".join(f"{value:g}" for value in corner) for corner in (corners[0], corners[-1]))
            text = (
                f"the plane lies outside the grid: the whole grid, from ({low}) to ({high}) m, is {by:.4g} m or more {side} it"
            )
            yield Finding((*path, "point"), text, "move `point` so that the plane cuts the grid")

    def _body_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        for number, name in enumerate(self.bodies):
            here = (*path, "bodies", number)
            yield from parts.unknown(BodyModel, here, name)
            body = parts.named(BodyModel, name)
            if name in self.bodies[:number]:
                yield Finding(here, f"body {name} is named twice", "remove one of them")
            elif body is not None and (reason := why_no_wall(body)):
                yield Finding(here, *reason)
            elif body is not None and is_driven(name, parts):
                text = f"body {name} has a fully prescribed motion: a wall cannot stop it"
                yield Finding(here, text, "remove it from `bodies`")
        bodies = parts.of(BodyModel)
        can = [body for body in bodies if not (why_no_wall(body) or is_driven(body.name, parts))]
        if not self.bodies and bodies and parts.are_sound(BodyModel) and not can:
            kinds = "material points, meshless solids and membranes of elements"
            text = f"no body of this case can touch it: only {kinds} can, unless their motion is fully prescribed"
            remedy = "remove this wall; for other kinds use a fixed body in its own velocity field and a [[contact]]"
            yield Finding(path, text, remedy)


def why_no_wall(body: BodyModel) -> Reason | None:
    """Return the reason why the body cannot have contact with walls (planes without a body), or None."""
    if body.separate_points or body.own_material_nodes:
        return None
    return Reason(f'body {body.name} of kind "{body.kind}" cannot have contact with a wall', "remove it from `bodies`")
