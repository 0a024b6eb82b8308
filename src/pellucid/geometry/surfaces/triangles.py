"""Generated surfaces of triangles: spheres, ellipsoids, red blood cells, discs."""

from typing import ClassVar

import numpy as np
from pydantic import PositiveFloat, field_validator

from pellucid.geometry.meshes.surface_mesh import NO_QUADS, Mesh, Meshed
from pellucid.geometry.meshes.triangulation import directed_edges, two_across
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


C0, C2, C4 = 0.1036, 1.0013, -0.5614
"""Coefficients of z = ±R sqrt(1 - x²) (C0 + C2 x² + C4 x⁴), x = r/R: Evans & Fung 1972, Microvasc. Res. 4, 335, divided by
R."""


class Biconcave(Meshed):
    """A red blood cell at rest, flat along z: the mean of measured cells, with a thickness proportional to the radius."""

    centre: Vector = parameter("m", "centre", (0.0, 0.0, 0.0))
    radius: float = parameter("m", "radius, such as 3.91 um", gt=0)
    refinements: int = parameter("", "number of times the triangles of an icosahedron are divided into four", 4, ge=0, le=8)

    closed: ClassVar[bool] = True

    def expected_points(self) -> float:
        return 10.0 * 4.0**self.refinements + 2.0

    def mesh(self) -> Mesh:
        """Return the mesh: a sphere whose vertices are moved along z; normals point outward."""
        sphere = Icosphere(centre=(0.0, 0.0, 0.0), radius=1.0, refinements=self.refinements).mesh()
        x, y, z = sphere.vertices.T
        square = np.minimum(x * x + y * y, 1.0)
        z = z * (C0 + square * (C2 + square * C4))  # on the sphere |z| is sqrt(1 - x²)
        vertices = np.array(self.centre) + self.radius * np.stack([x, y, z], axis=1)
        return Mesh(vertices, sphere.quads, sphere.triangles)


class Disc(Meshed):
    """A flat disc with rings of 6, 12, 18, ... points around its centre: 1 + 3 n (n + 1) points for n rings."""

    centre: Vector = parameter("m", "centre")
    normal: Vector = parameter("", "direction of the normal; its length is ignored")
    radius: float = parameter("m", "radius", gt=0)
    rings: int = parameter("", "number of rings of points around the centre; the last one lies on the edge", ge=1, le=1000)

    closed: ClassVar[bool] = False

    @field_validator("normal")
    @classmethod
    def _has_a_direction(cls, value: Vector) -> Vector:
        if not any(value):
            raise ValueError("`normal` has zero length; set a direction, such as [0, 0, 1]")
        return value

    def expected_points(self) -> float:
        return 3.0 * self.rings * (self.rings + 1.0) + 1.0

    def mesh(self) -> Mesh:
        """Return the mesh. The centre is the first point, followed by the rings outward; edges are 1 to 1.45 times radius /
        rings long."""
        first, second = two_across(np.array(self.normal))
        plane, triangles = rings_of_a_disc(self.rings)
        vertices = np.array(self.centre) + self.radius * (plane[:, :1] * first + plane[:, 1:] * second)
        return Mesh(vertices, NO_QUADS, triangles)


def rings_of_a_disc(rings: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the points of a unit disc, shape (n, 2), the centre and then the rings outward, and triangles, shape (m, 3)."""
    points, triangles = [np.zeros((1, 2))], []
    for ring in range(1, rings + 1):
        angle = np.arange(6 * ring) * (np.pi / (3 * ring))
        points.append(ring / rings * np.stack([np.cos(angle), np.sin(angle)], axis=1))
        triangles.append(_between_rings(ring))
    return np.concatenate(points), np.concatenate(triangles)


def _between_rings(ring: int) -> np.ndarray:
    """Return the triangles between a ring of a disc and the previous one, in six sectors, as point numbers, shape (m, 3);
    ring 0 is the centre."""
    sector, step = (a.ravel() for a in np.meshgrid(np.arange(6), np.arange(ring), indexing="ij"))

    def point(ring: int, sector: np.ndarray, step: np.ndarray) -> np.ndarray:
        start = 1 + 3 * ring * (ring - 1) if ring else 0
        return start + (sector * ring + step) % max(6 * ring, 1)

    outward = [point(ring - 1, sector, step), point(ring, sector, step), point(ring, sector, step + 1)]
    sector, step = sector[step < ring - 1], step[step < ring - 1]
    inward = [point(ring - 1, sector, step), point(ring, sector, step + 1), point(ring - 1, sector, step + 1)]
    return np.concatenate([np.stack(outward, axis=1), np.stack(inward, axis=1)])
