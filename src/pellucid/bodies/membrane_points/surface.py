"""The triangulated surface of membrane points: neighbours, normals, area shares."""

from typing import NamedTuple

import numpy as np

from pellucid.bodies.membranes.axes import axes_along
from pellucid.grid.nodal_fields import aligned_rows


class Fans(NamedTuple):
    """The triangles of a membrane, and for each point p the list of the triangles around the point, at the indices start[p]
    to start[p + 1] of `corners` and `triangle`.

    Triangles are numbered in the order of their points, so that neighbouring triangles are close in memory.
    """

    start: np.ndarray  # (n+1,) index in `corners` and `triangle` of the first triangle of each point
    corners: np.ndarray  # (3 m, 2) for each triangle around a point, its other two corners, counterclockwise
    triangle: np.ndarray  # (3 m,) numbers of the triangles around the points, in the order of `corners`
    triangles: np.ndarray  # (m, 3) points at the corners of the m triangles
    normals: np.ndarray  # (4 m,) unit normal and area [m²] of each triangle, computed by `find_normals`


def fans_of(triangles: np.ndarray, n: int) -> Fans:
    """List the triangles around each of n points. triangles: shape (m, 3), counterclockwise around the normal. The normals are
    not computed yet."""
    triangles = triangles[np.argsort(triangles.min(axis=1), kind="stable")].astype(np.int32)
    a, b, c = triangles.T
    owner = np.concatenate([a, b, c])
    corners = np.concatenate([np.stack(pair, axis=1) for pair in ((b, c), (c, a), (a, b))])
    order = np.argsort(owner, kind="stable")
    start = np.searchsorted(owner[order], np.arange(n + 1))
    number = (order % len(triangles)).astype(np.int32)
    return Fans(start, np.ascontiguousarray(corners[order]), number, triangles, aligned_rows(len(triangles)).reshape(-1))


def area_shares(position: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return a third of the area of all triangles around each point [m²], shape (n,). position: [m], shape (n, 3); triangles:
    shape (m, 3).
    """
    a, b, c = position[triangles.T]
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.bincount(triangles.ravel(), np.repeat(area / 3.0, 3), minlength=len(position))


def initial_frames(position: np.ndarray, triangles: np.ndarray, direction: np.ndarray | None = None) -> np.ndarray:
    """Return the initial frames of the points (rows t₁, t₂, n), shape (n, 9); the normal n is the normalised mean of the
    unit normals of the triangles around a point (Gan 2011, eq. 8).

    position: positions of the points [m], shape (n, 3); triangles: shape (m, 3); direction: vector, shape (3,), whose
    projection onto the surface has the direction of t₁; None: any tangent.
    """
    a, b, c = position[triangles.T]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    mean = np.zeros_like(position)
    for corner in triangles.T:
        np.add.at(mean, corner, normal)
    third = mean / np.linalg.norm(mean, axis=1)[:, None]
    # where any tangent will do, take the axis that is farthest from the normal
    away = np.eye(3)[np.argmin(np.abs(third), axis=1)] if direction is None else direction
    return np.ascontiguousarray(np.concatenate([*axes_along(away, mean), third], axis=1))
