"""An order of points in which neighbours in space mostly stand near each other: along Morton's curve."""

import numpy as np

from pellucid.geometry.meshes.triangulation import Triangulation

BITS = 10  # of a coordinate


def spatial_order(points: np.ndarray) -> np.ndarray:
    """The order of points [m], shape (n, 3), along the curve, shape (n,); points at one place keep their order."""
    lower = points.min(axis=0)
    extent = max(float((points.max(axis=0) - lower).max()), np.finfo(float).tiny)
    cells = np.minimum((points - lower) / extent * 2**BITS, 2**BITS - 1).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(BITS):
        for axis in range(3):
            code |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")


def side_by_side(mesh: Triangulation) -> Triangulation:
    """The same surface with nodes in that order, and triangles in the order of their nodes: what is near is near in memory."""
    order = spatial_order(mesh.vertices)
    number = np.empty(len(order), np.int64)
    number[order] = np.arange(len(order))
    triangles = number[mesh.triangles]
    turned = (triangles.argmin(axis=1)[:, None] + np.arange(3)) % 3
    triangles = np.take_along_axis(triangles, turned, axis=1)
    return Triangulation(mesh.vertices[order], triangles[np.argsort(triangles.sum(axis=1), kind="stable")])
