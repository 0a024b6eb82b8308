"""Open circular tube."""

from typing import ClassVar

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.meshes.surface_mesh import Mesh, Meshed, cut_to_box, grid_quads
from pellucid.geometry.meshes.triangulation import two_across
from pellucid.geometry.shapes.solids import Box
from pellucid.model import AtLeastThree, AtLeastTwo, Vector, check, parameter

REACH = 1e-9  # of the radius: tolerance by which a corner may lie outside the box, so that rounding does not decide


class BetweenEnds(Meshed):
    """A circular surface around the line between two points."""

    start: Vector = parameter("m", "centre of one end")
    end: Vector = parameter("m", "centre of the other end")
    radius: float = parameter("m", "radius", gt=0)

    @check
    def _has_a_length(self) -> None:
        if self.start == self.end:
            raise ValueError("`start` and `end` are the same point; move one of them")


class Tube(BetweenEnds):
    """An open circular tube of quadrilaterals; normals point outward."""

    points: tuple[AtLeastThree, AtLeastTwo] = parameter("", "number of points around the circumference, and along the axis")

    part: Box | None = parameter(
        "", "box that selects a part of the tube: quadrilaterals with all corners in it. Default: the whole tube", None
    )

    closed: ClassVar[bool] = False

    @check
    def _has_elements(self) -> None:
        if self.part is not None and not len(self.mesh().quads):
            text = "no quadrilateral of the tube has all corners in `part`"
            raise Refusal(text, "enlarge the box, move it to the surface, or increase `points`")

    def expected_points(self) -> float:
        return float(self.points[0]) * self.points[1]

    def mesh(self) -> Mesh:
        """Return the mesh, with points ordered ring by ring."""
        around, along = self.points
        axis = np.array(self.end) - np.array(self.start)
        side, up = two_across(axis)
        angle = 2.0 * np.pi * np.arange(around) / around
        ring = self.radius * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up)
        s = np.linspace(0.0, 1.0, along)
        vertices = (np.array(self.start) + s[None, :, None] * axis + ring[:, None, :]).reshape(-1, 3)
        quads = grid_quads(around, along, wrapped=True)
        if self.part is None:
            return Mesh(vertices, quads)
        bounds = self.part.bounds()
        part = cut_to_box(vertices, quads, bounds, REACH * self.radius)
        return part._replace(vertices=np.clip(part.vertices, *bounds))  # so that rims lie exactly in the planes of the box
