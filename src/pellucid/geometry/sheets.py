"""Flat rectangles of triangles."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from pellucid.geometry.triangulation import Triangulation, grid_triangles
from pellucid.model import Model, Vector, parameter

AtLeastTwo = Annotated[int, Field(ge=2)]


class Rectangle(Model):
    """A flat rectangle with its normal along the cross product of its edges; every square is cut in two."""

    corner: Vector = parameter("m", "a corner")
    first_edge: Vector = parameter("m", "edge from the corner")
    second_edge: Vector = parameter("m", "the other edge from the corner")
    points: tuple[AtLeastTwo, AtLeastTwo] = parameter("", "points along the first and the second edge")

    closed: ClassVar[bool] = False

    def triangulate(self) -> Triangulation:
        """The points row by row along the second edge."""
        n, m = self.points
        s, t = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, m), indexing="ij")
        vertices = (
            np.array(self.corner) + s.reshape(-1, 1) * np.array(self.first_edge) + t.reshape(-1, 1) * np.array(self.second_edge)
        )
        return Triangulation(vertices, grid_triangles(n, m, wrapped=False))
