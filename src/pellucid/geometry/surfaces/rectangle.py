"""Flat rectangles, and faces of boxes."""

from typing import ClassVar, Literal

import numpy as np

from pellucid.geometry.meshes.surface_mesh import Mesh, Meshed, grid_quads
from pellucid.geometry.shapes.contract import AXES
from pellucid.geometry.shapes.solids import Box
from pellucid.model import AtLeastTwo, Vector, parameter


class Rectangle(Meshed):
    """A flat rectangle of quadrilaterals, with its normal along the cross product of its edges."""

    corner: Vector = parameter("m", "position of a corner of the rectangle")
    first_edge: Vector = parameter("m", "edge from the corner")
    second_edge: Vector = parameter("m", "the other edge from the corner")
    points: tuple[AtLeastTwo, AtLeastTwo] = parameter("", "number of points along the first and the second edge")

    closed: ClassVar[bool] = False

    def expected_points(self) -> float:
        return float(self.points[0]) * self.points[1]

    def mesh(self) -> Mesh:
        """Return the mesh, with points ordered row by row along the second edge."""
        n, m = self.points
        s, t = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, m), indexing="ij")
        vertices = (
            np.array(self.corner) + s.reshape(-1, 1) * np.array(self.first_edge) + t.reshape(-1, 1) * np.array(self.second_edge)
        )
        return Mesh(vertices, grid_quads(n, m, wrapped=False))


class Lid(Meshed):
    """A face of a box, of quadrilaterals, with an outward normal."""

    box: Box = parameter("", "box, one face of which is the surface")
    face: Literal["x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper"] = parameter("", "face of the box")
    points: tuple[AtLeastTwo, AtLeastTwo] = parameter(
        "", "number of points along the two axes of the face, in the order x, y, z"
    )

    closed: ClassVar[bool] = False

    def expected_points(self) -> float:
        return float(self.points[0]) * self.points[1]

    def mesh(self) -> Mesh:
        """Return the mesh, with points ordered row by row along the second axis."""
        axis, upper = AXES.index(self.face[0]), self.face.endswith("upper")
        low, high = self.box.bounds()
        corner = low.copy()
        corner[axis] = high[axis] if upper else low[axis]
        first, second = (np.eye(3)[a] * (high - low)[a] for a in range(3) if a != axis)
        edges = {"corner": tuple(corner), "first_edge": tuple(first), "second_edge": tuple(second)}
        mesh = Rectangle(**edges, points=self.points).mesh()
        outward = upper != (axis == 1)  # x cross z is -y
        return mesh if outward else mesh.reversed()
