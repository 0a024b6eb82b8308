"""Spatial ordering of points along a Morton curve: neighbours in space are mostly close in memory."""

import numpy as np

from pellucid.geometry.meshes.triangulation import Triangulation

BITS = 10  # per coordinate


def spatial_order(points: np.ndarray) -> np.ndarray:
    """Return the order of points [m], shape (n, 3), along a Morton curve, shape (n,); coincident points keep their order."""
    lower = points.min(axis=0)
    extent = max(float((points.max(axis=0) - lower).max()), np.finfo(float).tiny)
    cells = np.minimum((points - lower) / extent * 2**BITS, 2**BITS - 1).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(BITS):
        for axis in range(3):
            code |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")


def side_by_side(mesh: Triangulation) -> Triangulation:
    """Return the same surface with its nodes in the order of `spatial_order`, and its triangles ordered by their mean node
    number, so that neighbouring triangles are close in memory. Each triangle starts at its smallest node number."""
    order = spatial_order(mesh.vertices)
    number = np.empty(len(order), np.int64)
    number[order] = np.arange(len(order))
    triangles = number[mesh.triangles]
    turned = (triangles.argmin(axis=1)[:, None] + np.arange(3)) % 3
    triangles = np.take_along_axis(triangles, turned, axis=1)
    return Triangulation(mesh.vertices[order], triangles[np.argsort(triangles.sum(axis=1), kind="stable")])
