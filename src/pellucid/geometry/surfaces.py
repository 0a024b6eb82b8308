"""Surfaces of membranes: rectangles, spheres and tubes as triangles."""

from typing import Annotated, Any, NamedTuple

import numpy as np
from pydantic import Field, model_validator

from pellucid.model import Model, Vector, parameter


class Triangulation(NamedTuple):
    """Vertices [m], shape (n, 3), and triangles, shape (m, 3), counterclockwise about the normal."""

    vertices: np.ndarray
    triangles: np.ndarray


AtLeastTwo = Annotated[int, Field(ge=2)]
AtLeastThree = Annotated[int, Field(ge=3)]


class Rectangle(Model):
    """A flat rectangle with its normal along the cross product of its edges; every square is cut in two."""

    corner: Vector = parameter("m", "a corner")
    first_edge: Vector = parameter("m", "edge from the corner")
    second_edge: Vector = parameter("m", "the other edge from the corner")
    points: tuple[AtLeastTwo, AtLeastTwo] = parameter("", "points along the first and the second edge")

    def triangulate(self) -> Triangulation:
        """The points row by row along the second edge."""
        n, m = self.points
        s, t = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, m), indexing="ij")
        vertices = (
            np.array(self.corner) + s.reshape(-1, 1) * np.array(self.first_edge) + t.reshape(-1, 1) * np.array(self.second_edge)
        )
        return Triangulation(vertices, _grid_triangles(n, m, wrapped=False))


class Icosphere(Model):
    """A sphere: an icosahedron whose triangles are cut in four, again and again; 10·4ᵏ + 2 points."""

    centre: Vector = parameter("m", "centre")
    radius: float = parameter("m", "radius", gt=0)
    refinements: int = parameter("", "how often the triangles are cut in four", 4, ge=0, le=8)

    def triangulate(self) -> Triangulation:
        """Normals point outward."""
        vertices, triangles = _icosahedron()
        for _ in range(self.refinements):
            vertices, triangles = _cut_in_four(vertices, triangles)
        return Triangulation(np.array(self.centre) + self.radius * vertices, triangles)


class Tube(Model):
    """An open circular tube; normals point outward."""

    start: Vector = parameter("m", "centre of one end")
    end: Vector = parameter("m", "centre of the other end")
    radius: float = parameter("m", "radius", gt=0)
    points: tuple[AtLeastThree, AtLeastTwo] = parameter("", "points around, and along the axis")

    def triangulate(self) -> Triangulation:
        """The points ring by ring."""
        around, along = self.points
        axis = np.array(self.end) - np.array(self.start)
        direction = axis / np.linalg.norm(axis)
        side = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
        side /= np.linalg.norm(side)
        up = np.cross(direction, side)
        angle = 2.0 * np.pi * np.arange(around) / around
        ring = self.radius * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up)
        s = np.linspace(0.0, 1.0, along)
        vertices = (np.array(self.start) + s[None, :, None] * axis + ring[:, None, :]).reshape(-1, 3)
        return Triangulation(vertices, _grid_triangles(around, along, wrapped=True))


class Surface(Model):
    """A table with one key that names the surface."""

    rectangle: Rectangle | None = None
    icosphere: Icosphere | None = None
    tube: Tube | None = None

    @model_validator(mode="before")
    @classmethod
    def _exactly_one(cls, data: Any) -> Any:
        if isinstance(data, dict) and len(data) != 1:
            names = ", ".join(cls.model_fields)
            raise ValueError(
                f"a surface is a table with exactly one of the keys {names}, for example {{ rectangle = {{ ... }} }}"
            )
        return data

    def triangulate(self) -> Triangulation:
        """Vertices and triangles."""
        return next(s for s in (self.rectangle, self.icosphere, self.tube) if s is not None).triangulate()


def _grid_triangles(n: int, m: int, wrapped: bool) -> np.ndarray:
    """Two triangles for each square of n × m points; where wrapped, the last row of squares joins the first."""
    i, j = np.meshgrid(np.arange(n if wrapped else n - 1), np.arange(m - 1), indexing="ij")
    a, b = (i * m + j).ravel(), ((i + 1) % n * m + j).ravel()
    lower, upper = np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)
    return np.stack([lower, upper], axis=1).reshape(-1, 3)


def _icosahedron() -> tuple[np.ndarray, np.ndarray]:
    g = 0.5 * (1.0 + np.sqrt(5.0))
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g)]
    corners += [(0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [
        (0, 11, 5),
        (0, 5, 1),
        (0, 1, 7),
        (0, 7, 10),
        (0, 10, 11),
        (1, 5, 9),
        (5, 11, 4),
        (11, 10, 2),
        (10, 7, 6),
        (7, 1, 8),
    ]
    faces += [(3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5), (2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    vertices = np.array(corners, dtype=float)
    return vertices / np.linalg.norm(vertices[0]), np.array(faces)


def _cut_in_four(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a, b, c = triangles.T
    edges = np.sort(np.concatenate([np.stack(pair, axis=1) for pair in ((a, b), (b, c), (c, a))]), axis=1)
    unique, which = np.unique(edges, axis=0, return_inverse=True)
    middle = vertices[unique].mean(axis=1)
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    ab, bc, ca = (which.reshape(3, -1) + len(vertices)).astype(int)
    cut = [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return np.concatenate([vertices, middle]), np.concatenate(cut)
