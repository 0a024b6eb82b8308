"""Area, enclosed volume and ellipsoid of a triangulated surface; an open one is closed by lids over its rims.

Integrals over what a surface encloses are sums over the tetrahedra between its triangles and a point, exact for a polyhedron.
The ellipsoid with the same volume and second moments M = ∫ x⊗x dV about the centroid has semi-axes sqrt(5 m/V) along the
eigenvectors of M with the eigenvalues m (Ramanujan & Pozrikidis 1998, J. Fluid Mech. 361, 117, take it for capsules).
"""

from typing import NamedTuple

import numpy as np

from pellucid.geometry.algorithms.lids import Lids, capped
from pellucid.geometry.meshes.cells import corner_areas

NOTHING = 1e-12  # of the third power of its extent: the volume of a flat surface


class Ellipsoid(NamedTuple):
    """Semi-axes [m], the longest first, shape (3,), and their directions, rows of a matrix, shape (3, 3)."""

    axes: np.ndarray
    directions: np.ndarray


def surface_area(position: np.ndarray, triangles: np.ndarray) -> float:
    """Area of the triangles [m²], without lids."""
    a, b, c = position[triangles.T]
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def volume_with_lids(position: np.ndarray, triangles: np.ndarray) -> float:
    """Volume inside [m³], negative where the normals turn inwards."""
    return Lids(position, triangles).volume(position, corner_areas(position, triangles))


def ellipsoid_of(position: np.ndarray, triangles: np.ndarray) -> Ellipsoid:
    """The ellipsoid of the same volume and second moments as what is inside; nan where that is nothing."""
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
    """Corners about the mean of the vertices, the fourth of each, shape (t, 3, 3), and volumes with their sign."""
    vertices, closed = capped(position, triangles)
    corners = vertices[closed] - position.mean(axis=0)
    return corners, np.linalg.det(corners) / 6.0
