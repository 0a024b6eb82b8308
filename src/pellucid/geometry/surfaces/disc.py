"""Flat disc of triangles."""

from typing import ClassVar

import numpy as np
from pydantic import field_validator

from pellucid.geometry.meshes.surface_mesh import NO_QUADS, Mesh, Meshed
from pellucid.geometry.meshes.triangulation import two_across
from pellucid.model import Vector, parameter


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
