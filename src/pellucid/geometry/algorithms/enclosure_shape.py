"""Area, enclosed volume and equivalent ellipsoid of a triangulated surface; an open surface is closed by lids over its rims.

Integrals over the enclosed space are sums over the tetrahedra between the triangles and a point, exact for a polyhedron. The
ellipsoid with the same ratio M/V of the second moments M = ∫ x⊗x dV about the centroid to the volume V has semi-axes
sqrt(5 m/V) along the eigenvectors of M with eigenvalues m (Ramanujan & Pozrikidis 1998, J. Fluid Mech. 361,
117, use it for capsules).
"""

from typing import NamedTuple

import numpy as np

from pellucid.geometry.algorithms.lids import Lids, capped
from pellucid.geometry.meshes.cells import corner_areas

NOTHING = 1e-12  # of the cube of the extent: a surface with a smaller volume is flat


class Ellipsoid(NamedTuple):
    """An ellipsoid: semi-axes [m], longest first, shape (3,), and their directions as rows of a matrix, shape (3, 3)."""

    axes: np.ndarray
    directions: np.ndarray


def surface_area(position: np.ndarray, triangles: np.ndarray) -> float:
    """Return the total area of triangles [m²], without lids over rims. position: vertices [m], shape (n, 3); triangles:
    vertex numbers, shape (m, 3)."""
    a, b, c = position[triangles.T]
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def volume_with_lids(position: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume enclosed by triangles and the lids over their rims [m³], negative if the normals point inward.
    position: vertices [m], shape (n, 3); triangles: vertex numbers, shape (m, 3)."""
    return Lids(position, triangles).volume(position, corner_areas(position, triangles))


def ellipsoid_of(position: np.ndarray, triangles: np.ndarray) -> Ellipsoid:
    """Return the ellipsoid that has the same second moments about its centroid per volume as the space enclosed by
    triangles and the lids over their rims; its semi-axes and directions are NaN if the volume is zero. position: vertices
    [m], shape (n, 3); triangles: vertex numbers, shape (m, 3)."""
    corners, volumes = _tetrahedra(position, triangles)
    volume = float(volumes.sum())
    if abs(volume) <= NOTHING * float(np.ptp(position, axis=0).max()) ** 3:
        return Ellipsoid(np.full(3, np.nan), np.full((3, 3), np.nan))
    centre = (volumes[:, None] * corners.sum(axis=1)).sum(axis=0) / (4.0 * volume)
    first = (volumes[:, None] * corners.sum(axis=1)).sum(axis=0) / 4.0
    sums = corners.sum(axis=1)
    second = np.einsum("t,tki,tkj->ij", volumes, corners, corners) + np.einsum("t,ti,tj->ij", volumes, sums, sums)
    moments, directions = np.linalg.eigh(second / 20.0 - np.outer(centre, first))
    axes = np.sqrt(5.0 * np.maximum(moments / volume, 0.0))
    return Ellipsoid(axes[::-1].copy(), directions.T[::-1].copy())


def _tetrahedra(position: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return a division of the space enclosed by triangles and the lids over their rims into tetrahedra: three corners of
    each relative to the fourth (the mean vertex) [m], shape (t, 3, 3), and signed volumes [m³], shape (t,). position:
    vertices [m], shape (n, 3); triangles: vertex numbers, shape (m, 3)."""
    vertices, closed = capped(position, triangles)
    corners = vertices[closed] - position.mean(axis=0)
    return corners, np.linalg.det(corners) / 6.0
