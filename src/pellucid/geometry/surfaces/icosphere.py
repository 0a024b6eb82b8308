"""Spheres and ellipsoids of triangles."""

from typing import ClassVar

import numpy as np
from pydantic import PositiveFloat

from pellucid.geometry.meshes.surface_mesh import NO_QUADS, Mesh, Meshed
from pellucid.geometry.meshes.triangulation import directed_edges
from pellucid.model import Vector, parameter


class Icosphere(Meshed):
    """A sphere: an icosahedron whose triangles are repeatedly divided into four; 10·4ᵏ + 2 points after k divisions."""

    centre: Vector = parameter("m", "centre")
    radius: float = parameter("m", "radius", gt=0)
    refinements: int = parameter("", "number of times the triangles of an icosahedron are divided into four", 4, ge=0, le=8)

    closed: ClassVar[bool] = True

    def expected_points(self) -> float:
        return 10.0 * 4.0**self.refinements + 2.0

    def mesh(self) -> Mesh:
        """Build and return the mesh of the sphere; normals point outward."""
        vertices, triangles = _icosahedron()
        for _ in range(self.refinements):
            vertices, triangles = _cut_in_four(vertices, triangles)
        return Mesh(np.array(self.centre) + self.radius * vertices, NO_QUADS, triangles)


def _icosahedron() -> tuple[np.ndarray, np.ndarray]:
    g = 0.5 * (1.0 + np.sqrt(5.0))
    corners = [(-1, g, 0), (1, g, 0), (-1, -g, 0), (1, -g, 0), (0, -1, g), (0, 1, g)]
    corners += [(0, -1, -g), (0, 1, -g), (g, 0, -1), (g, 0, 1), (-g, 0, -1), (-g, 0, 1)]
    faces = [(0, 11, 5), (0, 5, 1), (0, 1, 7), (0, 7, 10), (0, 10, 11), (1, 5, 9), (5, 11, 4), (11, 10, 2)]
    faces += [(10, 7, 6), (7, 1, 8), (3, 9, 4), (3, 4, 2), (3, 2, 6), (3, 6, 8), (3, 8, 9), (4, 9, 5)]
    faces += [(2, 4, 11), (6, 2, 10), (8, 6, 7), (9, 8, 1)]
    vertices = np.array(corners, dtype=float)
    return vertices / np.linalg.norm(vertices[0]), np.array(faces)


def _cut_in_four(vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a, b, c = triangles.T
    low, high = np.sort(directed_edges(triangles), axis=1).T
    codes, which = np.unique(low * len(vertices) + high, return_inverse=True)
    unique = np.stack([codes // len(vertices), codes % len(vertices)], axis=1)
    middle = vertices[unique].mean(axis=1)
    middle /= np.linalg.norm(middle, axis=1)[:, None]
    ab, bc, ca = (which.reshape(3, -1) + len(vertices)).astype(int)
    cut = [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return np.concatenate([vertices, middle]), np.concatenate(cut)


class EllipsoidSurface(Meshed):
    """An ellipsoid: a sphere of triangles stretched along the axes; 10·4ᵏ + 2 points after k divisions."""

    centre: Vector = parameter("m", "centre", (0.0, 0.0, 0.0))
    radii: tuple[PositiveFloat, PositiveFloat, PositiveFloat] = parameter("m", "radii along x, y and z")
    refinements: int = parameter("", "number of times the triangles of an icosahedron are divided into four", 4, ge=0, le=8)

    closed: ClassVar[bool] = True

    def expected_points(self) -> float:
        return 10.0 * 4.0**self.refinements + 2.0

    def mesh(self) -> Mesh:
        """Build and return the mesh of the ellipsoid; normals point outward."""
        sphere = Icosphere(centre=(0.0, 0.0, 0.0), radius=1.0, refinements=self.refinements).mesh()
        return Mesh(np.array(self.centre) + sphere.vertices * np.array(self.radii), sphere.quads, sphere.triangles)
