"""A face of a box as a membrane."""

from typing import ClassVar, Literal

import numpy as np

from pellucid.geometry.geometry import AXES
from pellucid.geometry.mesh import Mesh, Meshed
from pellucid.geometry.sheets import AtLeastTwo, Rectangle
from pellucid.geometry.solids import Box
from pellucid.model import parameter


class Lid(Meshed):
    """A face of a box with its normal outward, in squares."""

    box: Box = parameter("", "the box")
    face: Literal["x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper"] = parameter("", "which of its faces")
    points: tuple[AtLeastTwo, AtLeastTwo] = parameter("", "points along the two axes of the face, in the order x, y, z")

    closed: ClassVar[bool] = False

    def expected_points(self) -> float:
        """See `Meshed`."""
        return float(self.points[0]) * self.points[1]

    def mesh(self) -> Mesh:
        """The points row by row along the second axis."""
        axis, upper = AXES.index(self.face[0]), self.face.endswith("upper")
        low, high = self.box.bounds()
        corner = low.copy()
        corner[axis] = high[axis] if upper else low[axis]
        first, second = (np.eye(3)[a] * (high - low)[a] for a in range(3) if a != axis)
        edges = {"corner": tuple(corner), "first_edge": tuple(first), "second_edge": tuple(second)}
        mesh = Rectangle(**edges, points=self.points).mesh()
        outward = upper != (axis == 1)  # x cross z is -y
        return mesh if outward else mesh.reversed()
