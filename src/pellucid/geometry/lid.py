"""A face of a box as a membrane."""

from typing import ClassVar, Literal

import numpy as np

from pellucid.geometry.geometry import AXES
from pellucid.geometry.sheets import AtLeastTwo, Rectangle
from pellucid.geometry.solids import Box
from pellucid.geometry.triangulation import Triangulation
from pellucid.model import Model, parameter


class Lid(Model):
    """A face of a box with its normal outward; every square is cut in two."""

    box: Box = parameter("", "the box")
    face: Literal["x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper"] = parameter("", "which of its faces")
    points: tuple[AtLeastTwo, AtLeastTwo] = parameter("", "points along the two axes of the face, in the order x, y, z")

    closed: ClassVar[bool] = False

    def triangulate(self) -> Triangulation:
        """The points row by row along the second axis."""
        axis, upper = AXES.index(self.face[0]), self.face.endswith("upper")
        low, high = self.box.bounds()
        corner = low.copy()
        corner[axis] = high[axis] if upper else low[axis]
        first, second = (np.eye(3)[a] * (high - low)[a] for a in range(3) if a != axis)
        edges = {"corner": tuple(corner), "first_edge": tuple(first), "second_edge": tuple(second)}
        vertices, triangles = Rectangle(**edges, points=self.points).triangulate()
        outward = upper != (axis == 1)  # x cross z is -y
        return Triangulation(vertices, triangles if outward else triangles[:, ::-1].copy())
