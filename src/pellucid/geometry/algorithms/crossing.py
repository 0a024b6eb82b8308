"""Intersections of triangulated surfaces, including surfaces that lie on each other."""

import numpy as np

from pellucid.geometry.algorithms.bounding_tree import BoundingTree
from pellucid.geometry.meshes.triangulation import Triangulation

ROUNDING = 1e-9  # of an edge


def crossing(first: Triangulation, second: Triangulation) -> np.ndarray | None:
    """Return a position [m], shape (3,), where an edge of one of two surfaces intersects a triangle of the other surface;
    None if the surfaces do not intersect.

    An edge or vertex that lies on a triangle counts as an intersection.
    """
    for one, other in ((first, second), (second, first)):
        place = _piercing(one, other, np.arange(len(one.vertices)), -2 - np.arange(len(other.vertices)), True)
        if place is not None:
            return place
    return None


def self_crossing(surface: Triangulation, in_plane: bool = True) -> np.ndarray | None:
    """Return a position [m], shape (3,), where an edge of a surface intersects a triangle that does not share a vertex with
    it; None if there is none.

    Coincident vertices count as one. in_plane: True to also count edges that lie in the plane of a triangle; use False
    for surfaces with layers that touch each other.
    """
    number = np.unique(surface.vertices + 0.0, axis=0, return_inverse=True)[1].reshape(-1)
    return _piercing(surface, surface, number, number, in_plane)


def _piercing(
    one: Triangulation, other: Triangulation, of_one: np.ndarray, of_other: np.ndarray, in_plane: bool
) -> np.ndarray | None:
    """Return the first position [m] where an edge of the surface `one` intersects a triangle of the surface `other`, or
    None; triangles that share a vertex with the edge are ignored. of_one, of_other: a number for each vertex of the
    surfaces, equal for coincident vertices; in_plane: as in `self_crossing`."""
    edges = np.unique(np.sort(one.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    start, end = one.vertices[edges[:, 0]], one.vertices[edges[:, 1]]
    corners, numbers = other.vertices[other.triangles], of_other[other.triangles]
    slack = ROUNDING * float(np.ptp(corners, axis=(0, 1)).max())
    lower, upper = other.vertices.min(axis=0) - slack, other.vertices.max(axis=0) + slack
    inside = np.all((np.maximum(start, end) >= lower) & (np.minimum(start, end) <= upper), axis=1)
    edges, start, end = of_one[edges[inside]], start[inside], end[inside]
    if not len(edges):
        return None
    for e, t in BoundingTree(corners, numbers, slack).near(edges, start, end):
        strange = (edges[e][:, :, None] != numbers[t][:, None, :]).all(axis=(1, 2))
        e, t = e[strange], t[strange]
        meets, places = _meeting(start[e], (end - start)[e], corners[t], slack, in_plane)
        if meets.any():
            found = np.flatnonzero(meets)
            return np.asarray(places[found[np.lexsort((t[found], e[found]))[0]]])
    return None


def _meeting(p: np.ndarray, d: np.ndarray, corners: np.ndarray, slack: float, in_plane: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return a mask of the edges, from positions p to p + d [m], shape (k, 3), that intersect their triangles, and the
    intersection points [m].

    corners: triangle tested with each edge [m], shape (k, 3, 3); slack: distance below which a parallel edge lies in the
    plane of its triangle [m]; in_plane: count such edges. Source: Möller & Trumbore 1997, J. Graph. Tools 2, 21.
    """
    a = corners[:, 0]
    u, v = corners[:, 1] - a, corners[:, 2] - a
    normal, h = np.cross(u, v), np.cross(d, v)
    determinant = np.sum(u * h, axis=1)
    along = np.abs(determinant) <= ROUNDING * np.linalg.norm(d, axis=1) * np.linalg.norm(normal, axis=1)
    # an edge parallel to a triangle intersects it if its start lies on the triangle
    scale = np.where(along, np.sum(normal * normal, axis=1), determinant)
    s = p - a
    foot = s - np.sum(s * normal, axis=1)[:, None] / np.sum(normal * normal, axis=1)[:, None] * normal
    q = np.cross(s, u)
    U = np.where(along, np.sum(np.cross(foot, v) * normal, axis=1), np.sum(s * h, axis=1)) / scale
    V = np.where(along, np.sum(np.cross(u, foot) * normal, axis=1), np.sum(d * q, axis=1)) / scale
    share = np.where(along, 0.0, np.sum(v * q, axis=1) / scale)
    height = np.abs(np.sum(s * normal, axis=1)) / np.linalg.norm(normal, axis=1)
    within = (U >= -ROUNDING) & (V >= -ROUNDING) & (U + V <= 1.0 + ROUNDING)
    meets = within & (share >= -ROUNDING) & (share <= 1.0 + ROUNDING) & (~along | (height <= slack))
    return meets & (in_plane | ~along), p + share[:, None] * d
