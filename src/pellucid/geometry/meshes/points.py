"""Coincident points of files and meshes, and the order of points in memory."""

import numpy as np

from pellucid.geometry.meshes.triangulation import Triangulation, pieces

NEAR = 1e-6  # of the mean edge: points at a smaller distance are coincident
SINGLE = 2.0**-22  # of the largest coordinate: two units in the last place of single precision, as of binary STL
MOST = 1e-3  # of the mean edge, however far from the origin the mesh lies


def width_of_place(points: np.ndarray, elements: list[np.ndarray]) -> float:
    """Return the distance [unit of the points] below which two of n points, shape (n, 3), are coincident.

    It allows for the precision of a file. elements: point numbers of the corners, shape (m, corners), for each kind of
    element.
    """
    edges = [np.linalg.norm(points[corners] - np.roll(points[corners], 1, axis=1), axis=2).ravel() for corners in elements]
    lengths = np.concatenate([np.zeros(0), *edges])
    lengths = lengths[lengths > 0.0]
    if not len(lengths):
        return 0.0
    mean = float(lengths.mean())
    return min(max(NEAR * mean, SINGLE * float(np.abs(points).max())), MOST * mean)


def same_place(points: np.ndarray, elements: list[np.ndarray]) -> np.ndarray:
    """Return for each of n points [any unit], shape (n, 3), the smallest number of a coincident point, shape (n,).

    elements: point numbers of the corners, shape (m, corners), for each kind of element; they define the distance up to which
    points coincide (`width_of_place`).
    """
    from scipy.spatial import cKDTree

    limit = width_of_place(points, elements)
    if limit == 0.0:
        _, first, which = np.unique(points, axis=0, return_index=True, return_inverse=True)
        return np.asarray(first[which.reshape(-1)])
    return pieces(cKDTree(points).query_pairs(limit, output_type="ndarray").reshape(-1, 2), len(points))


COINCIDENT = 1e-6  # of the mean distance between neighbours: far above rounding errors, far below any intended spacing


def coincident(places: np.ndarray, sides: np.ndarray) -> tuple[int, int] | None:
    """Return the first two coincident nodes, neighbours or not, among the positions `places` [m], shape (n, d); None if no
    nodes coincide. sides: corners of the elements between the nodes, shape (m, corners); the mean length of these elements
    sets the tolerance."""
    from scipy.spatial import cKDTree

    corners = places[sides]
    mean = float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())
    pairs = cKDTree(places).query_pairs(COINCIDENT * mean, output_type="ndarray")
    if not len(pairs):
        return None
    one, other = min(map(tuple, np.sort(pairs, axis=1).tolist()))
    return one, other


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
