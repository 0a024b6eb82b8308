"""Detection of coincident points of a file and coincident nodes of a mesh."""

import numpy as np

from pellucid.geometry.meshes.triangulation import pieces

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
