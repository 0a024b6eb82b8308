"""Flat rectangles."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from pellucid.geometry.mesh import Mesh, Meshed, grid_quads
from pellucid.model import Vector, parameter

AtLeastTwo = Annotated[int, Field(ge=2)]


class Rectangle(Meshed):
    """A flat rectangle with its normal along the cross product of its edges, in squares."""

    corner: Vector = parameter("m", "a corner")
    first_edge: Vector = parameter("m", "edge from the corner")
    second_edge: Vector = parameter("m", "the other edge from the corner")
    points: tuple[AtLeastTwo, AtLeastTwo] = parameter("", "points along the first and the second edge")

    closed: ClassVar[bool] = False

    def expected_points(self) -> float:
        """See `Meshed`."""
        return float(self.points[0]) * self.points[1]

    def mesh(self) -> Mesh:
        """The points row by row along the second edge."""
        n, m = self.points
        s, t = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, m), indexing="ij")
        vertices = (
            np.array(self.corner) + s.reshape(-1, 1) * np.array(self.first_edge) + t.reshape(-1, 1) * np.array(self.second_edge)
        )
        return Mesh(vertices, grid_quads(n, m, wrapped=False))
