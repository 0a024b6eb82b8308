"""Where two triangulated surfaces cross or lie on each other."""

import numpy as np

from pellucid.geometry.meshes.triangulation import Triangulation

ROUNDING = 1e-9  # of an edge


def crossing(first: Triangulation, second: Triangulation) -> np.ndarray | None:
    """A place [m], shape (3,), where an edge of one goes through a triangle of the other or a vertex lies on one; else None."""
    for one, other in ((first, second), (second, first)):
        found = _piercing(one, other)
        if len(found):
            return np.asarray(found[0])
    return None


def self_crossing(surface: Triangulation) -> np.ndarray | None:
    """A place [m], shape (3,), where an edge of a surface meets a triangle that has none of its vertices; else None."""
    found = _piercing(surface, surface, apart=True)
    return np.asarray(found[0]) if len(found) else None


def _piercing(one: Triangulation, other: Triangulation, apart: bool = False) -> np.ndarray:
    """Where edges of one meet triangles of the other, shape (n, 3) (Möller & Trumbore 1997, J. Graph. Tools 2, 21); `apart`:
    both are one surface, and an edge does not meet the triangles at its own vertices."""
    from scipy.spatial import cKDTree

    edges = np.unique(np.sort(one.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    start, end = one.vertices[edges[:, 0]], one.vertices[edges[:, 1]]
    corners = other.vertices[other.triangles]
    slack = ROUNDING * float(np.ptp(corners, axis=(0, 1)).max())
    lower, upper = other.vertices.min(axis=0) - slack, other.vertices.max(axis=0) + slack
    inside = np.all((np.maximum(start, end) >= lower) & (np.minimum(start, end) <= upper), axis=1)
    edges, start, end = edges[inside], start[inside], end[inside]
    if not len(edges):
        return np.zeros((0, 3))
    sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    reach = 0.5 * float(np.linalg.norm(end - start, axis=1).max()) + float(sides.max())
    near = cKDTree(0.5 * (start + end)).query_ball_tree(cKDTree(corners.mean(axis=1)), reach)
    e = np.repeat(np.arange(len(edges)), [len(found) for found in near])
    t = np.array([triangle for found in near for triangle in found], dtype=int)
    if apart:
        strange = (edges[e][:, :, None] != other.triangles[t][:, None, :]).all(axis=(1, 2))
        e, t = e[strange], t[strange]
    p, d, a = start[e], (end - start)[e], corners[t, 0]
    u, v = corners[t, 1] - a, corners[t, 2] - a
    normal, h = np.cross(u, v), np.cross(d, v)
    determinant = np.sum(u * h, axis=1)
    along = np.abs(determinant) <= ROUNDING * np.linalg.norm(d, axis=1) * np.linalg.norm(normal, axis=1)
    # an edge along a triangle meets it where its start lies on it
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
    return np.asarray((p + share[:, None] * d)[meets])
