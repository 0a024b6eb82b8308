"""Supports: nodes whose velocity is prescribed."""

from typing import Literal

from pydantic import field_validator, model_validator

from pellucid.geometry.shapes import Box
from pellucid.model import Model, Vector, parameter

Face = Literal["x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper"]
Axis = Literal["x", "y", "z"]


class BoxRegion(Model):
    """The nodes inside a box."""

    box: Box


class Support(Model):
    """Prescribed nodal velocity. `fix = "normal"` on a face is a symmetry plane or slip wall; a velocity moves the wall."""

    name: str | None = parameter("", "name for probes of its reaction", None, pattern=r"^[A-Za-z][A-Za-z0-9_-]*$")
    where: Literal["all-nodes"] | Face | BoxRegion = parameter("", "which nodes: all-nodes, a face of the grid, or a box")
    fix: tuple[Axis, ...] | Literal["normal"] = parameter("", "held directions", ("x", "y", "z"))
    velocity: Vector = parameter("m/s", "velocity of the held directions", (0.0, 0.0, 0.0))

    @field_validator("fix")
    @classmethod
    def _something_is_held(cls, fix: tuple[Axis, ...] | Literal["normal"]) -> tuple[Axis, ...] | Literal["normal"]:
        if not fix:
            raise ValueError('fix holds no direction; list some of "x", "y", "z", or leave the support out')
        return fix

    @model_validator(mode="after")
    def _normal_needs_a_face(self) -> "Support":
        if self.fix == "normal" and (not isinstance(self.where, str) or self.where == "all-nodes"):
            raise ValueError('fix = "normal" needs a face of the grid as `where`, such as "x-lower"')
        return self

    def axes(self) -> tuple[bool, bool, bool]:
        """Which directions are held."""
        held = (self.where[0],) if self.fix == "normal" and isinstance(self.where, str) else self.fix
        return "x" in held, "y" in held, "z" in held

    def face(self) -> tuple[int, int] | None:
        """The axis and the end, 0 lower and 1 upper, of the face of the grid on which it is, if it is on one."""
        if isinstance(self.where, BoxRegion) or self.where == "all-nodes":
            return None
        return "xyz".index(self.where[0]), ("lower", "upper").index(self.where[2:])
