"""Sharp edges of surfaces: vertices there are split, so that each side is shaded by its own normals."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

SHARP = 40.0  # degrees between the normals of neighbouring triangles


class Faceted(NamedTuple):
    """A surface whose vertices at sharp edges are split, so that normals for shading differ on both sides of an edge:
    triangles as new vertex numbers, shape (m, 3), and the original vertex of each new vertex, shape (k,)."""

    triangles: np.ndarray
    vertex: np.ndarray


def split_at_creases(vertices: np.ndarray, triangles: np.ndarray) -> Faceted:
    """Split the vertices of a surface, shape (n, 3) [m], at every sharp edge, i.e. where the normals of two adjacent triangles
    differ by more than 40 degrees. triangles: vertex numbers, shape (m, 3)."""
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    normals = np.cross(b - a, c - a)
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), np.finfo(float).tiny)
    corners = np.arange(triangles.size).reshape(-1, 3)
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()  # the corners at both ends of each edge
    of = triangles.ravel()
    codes = np.minimum(of[start], of[end]) * len(vertices) + np.maximum(of[start], of[end])
    order = np.argsort(codes, kind="stable")
    same = codes[order][1:] == codes[order][:-1]
    one, other = order[:-1][same], order[1:][same]
    smooth = np.einsum("ij,ij->i", normals[one // 3], normals[other // 3]) > np.cos(np.radians(SHARP))
    one, other = one[smooth], other[smooth]
    alike = of[start[one]] == of[start[other]]
    links = (
        np.concatenate([start[one], end[one]]),
        np.concatenate([np.where(alike, start[other], end[other]), np.where(alike, end[other], start[other])]),
    )
    _, number = connected_components(coo_array((np.ones(len(links[0])), links), shape=(of.size, of.size)), directed=False)
    vertex = np.empty(number.max(initial=-1) + 1, np.int64)
    vertex[number] = of
    return Faceted(number.reshape(-1, 3).astype(np.int64), vertex)
