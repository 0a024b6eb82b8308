"""Triangulations: edges, connected components, normals."""

from typing import NamedTuple

import numpy as np


class Triangulation(NamedTuple):
    """Vertices [m], shape (n, 3), and triangles, shape (m, 3), counterclockwise about the normal."""

    vertices: np.ndarray
    triangles: np.ndarray


def bounding_box(places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the lower and upper corner, shape (d,) each, of the bounding box of positions, shape (n, d)."""
    return places.min(axis=0), places.max(axis=0)


def directed_edges(elements: np.ndarray) -> np.ndarray:
    """Return the directed edges of m elements with k corners, shape (k m, 2): the first edges of all elements, then the second
    ones, ..."""
    return np.concatenate([np.stack(pair, axis=1) for pair in zip(elements.T, np.roll(elements, -1, axis=1).T, strict=True)])


def pair_edges(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the h edges that two of t triangles share, each with two indices: as an edge of one triangle, and as an edge of
    the other, shape (h,) each.

    Edges are numbered as in `directed_edges`: t k + number of the triangle for its edge k. triangles: shape (t, 3),
    consistently oriented.
    """
    ends = directed_edges(triangles)
    code = triangles.max(initial=0) + 1
    forth, back = ends[:, 0] * code + ends[:, 1], ends[:, 1] * code + ends[:, 0]
    order = np.argsort(forth)
    found = np.minimum(np.searchsorted(forth[order], back), len(order) - 1)
    paired = (forth[order][found] == back) & (ends[:, 0] < ends[:, 1])
    chosen = np.flatnonzero(paired)
    return chosen, order[found[chosen]]


def first_of_each(elements: np.ndarray) -> np.ndarray:
    """Return a mask of the elements, shape (m,), that is False if an earlier element has the same corners in any order."""
    first = np.zeros(len(elements), bool)
    first[np.unique(np.sort(elements, axis=1), axis=0, return_index=True)[1]] = True
    return first


def two_across(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two unit vectors that form a right-handed frame with the direction of `normal`, shape (3,) each."""
    direction = normal / np.linalg.norm(normal)
    first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    first /= np.linalg.norm(first)
    return first, np.cross(direction, first)


def pieces(links: np.ndarray, n: int) -> np.ndarray:
    """Label connected components: return for each of n vertices the smallest vertex connected to it; links: pairs of
    directly connected vertices, shape (m, 2)."""
    from scipy.sparse import coo_array, csgraph  # slow import, not needed to read a case

    graph = coo_array((np.ones(len(links), np.int8), (links[:, 0], links[:, 1])), shape=(n, n))
    number = csgraph.connected_components(graph, directed=False)[1]
    smallest = np.unique(number, return_index=True)[1]
    return np.asarray(smallest[number])


def vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return unit normals at the vertices [m], shape (n, 3), of a closed surface of triangles, shape (m, 3): shape (n, 3).

    The cross products of the edges at a vertex are divided by the squares of their lengths: exact on a sphere, second order on
    smooth surfaces (Max 1999, J. Graph. Tools 4(2), 1).
    """
    normals = np.zeros_like(vertices)
    for corner in range(3):
        here, after, before = (triangles[:, (corner + k) % 3] for k in range(3))
        one, other = vertices[after] - vertices[here], vertices[before] - vertices[here]
        lengths = (one * one).sum(axis=1) * (other * other).sum(axis=1)
        np.add.at(normals, here, np.cross(one, other) / lengths[:, None])
    return normals / np.linalg.norm(normals, axis=1)[:, None]
