"""Supports: nodes whose velocity is prescribed."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Literal

import numpy as np
from pydantic import field_validator, model_validator

from pellucid.findings import Finding, Path
from pellucid.geometry.shapes import Box
from pellucid.model import Model, Vector, parameter
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts

if TYPE_CHECKING:
    from pellucid.parts.assembly import Assembly

Face = Literal["x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper"]
Axis = Literal["x", "y", "z"]


class BoxRegion(Model):
    """The nodes inside a box."""

    box: Box


class Support(Condition):
    """Prescribed nodal velocity. `fix = "normal"` on a face is a symmetry plane or slip wall; a velocity moves the wall."""

    name: str | None = parameter("", "name for probes of its reaction", None, pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
    where: Literal["all-nodes"] | Face | BoxRegion = parameter("", "which nodes: all-nodes, a face of the grid, or a box")
    fix: tuple[Axis, ...] | Literal["normal"] = parameter("", "constrained directions", ("x", "y", "z"))
    velocity: Vector = parameter("m/s", "velocity of the constrained directions", (0.0, 0.0, 0.0))

    @field_validator("fix")
    @classmethod
    def _something_is_fixed(cls, fix: tuple[Axis, ...] | Literal["normal"]) -> tuple[Axis, ...] | Literal["normal"]:
        if not fix:
            raise ValueError('fix names no direction; list some of "x", "y", "z", or leave the support out')
        return fix

    @model_validator(mode="after")
    def _normal_needs_a_face(self) -> "Support":
        if self.fix == "normal" and (not isinstance(self.where, str) or self.where == "all-nodes"):
            raise ValueError('fix = "normal" needs a face of the grid as `where`, such as "x-lower"')
        return self

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A face of a grid that is not there, a box in which there is no node."""
        if self.face() is not None:
            yield from parts.no_grid((*path, "where"), "faces are those of a grid")
        grid = parts.grid
        if grid is None or not isinstance(self.where, BoxRegion):
            return
        lower, upper = self.where.box.bounds()
        ends = zip("xyz", lower, upper, grid.lower, grid.extent_upper(), grid.thin(), strict=True)
        for axis, low, high, grid_low, grid_high, thin in ends:
            if not thin and (high < low or high < grid_low or low > grid_high):
                box, nodes = f"{low:g} to {high:g} m", f"{grid_low:g} to {grid_high:g} m"
                text = f"the box contains no node: {axis} from {box}, the grid's from {nodes}"
                yield Finding((*path, "where", "box"), text, "let the box overlap the grid")

    @classmethod
    def activate(cls, conditions: Sequence["Support"], assembly: "Assembly") -> Sequence[ActiveCondition]:
        """Constrain the nodes of all grids, where axes may be thin too, and those of bodies with their own."""
        from pellucid.conditions.constrained_nodes import constrain_nodes, nodal_support

        for actions in assembly.actions:
            actions.supports = constrain_nodes(actions.field.grid, conditions)
        for member in assembly.bodies.values():
            grid = member.velocity_field.grid if member.velocity_field else None
            member.body.add_supports([nodal_support(grid, support) for support in conditions])
        return ()

    def reaction(self) -> str | None:
        """Its own name."""
        return self.name

    def constrains_face(self, face: str) -> bool:
        """Whether it constrains this face of the grid."""
        return self.where == face

    def face_velocity(self, face: str) -> Vector | None:
        """Its velocity [m/s], if it constrains this face of the grid along its normal."""
        return self.velocity if self.constrains_face(face) and self.axes()["xyz".index(face[0])] else None

    def box(self) -> tuple[np.ndarray, np.ndarray] | None:
        """Lower and upper corner [m] of the box in which it constrains nodes, if it is one."""
        return self.where.box.bounds() if isinstance(self.where, BoxRegion) else None

    def axes(self) -> tuple[bool, bool, bool]:
        """Which directions are constrained."""
        axes = (self.where[0],) if self.fix == "normal" and isinstance(self.where, str) else self.fix
        return "x" in axes, "y" in axes, "z" in axes

    def face(self) -> tuple[int, int] | None:
        """The axis and the end, 0 lower and 1 upper, of the face of the grid on which it is, if it is on one."""
        if isinstance(self.where, BoxRegion) or self.where == "all-nodes":
            return None
        return "xyz".index(self.where[0]), ("lower", "upper").index(self.where[2:])
