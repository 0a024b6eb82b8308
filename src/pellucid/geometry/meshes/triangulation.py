"""Triangulations: edges, connected components, normals and axes in the plane, ordered neighbours of the
nodes."""

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


def axes_along(direction: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two in-plane unit vectors for planes with normals `normal`, shape (n, 3), of any length. The first vectors, shape
    (n, 3), lie along the projection of `direction`, shape (3,) or one for each plane (n, 3); the second ones are perpendicular
    to them.
    """
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    first = direction - np.sum(direction * normal, axis=1)[:, None] * normal
    first /= np.linalg.norm(first, axis=1)[:, None]
    return first, np.cross(normal, first)


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


class Rings(NamedTuple):
    """Half-edges (edges of one triangle, in its direction) and one-rings (neighbours of a node in order) of a triangulation.
    Half-edge 3 t + k starts at corner k of triangle t; rings are counterclockwise about the normal."""

    triangles: np.ndarray  # (e, 3) corners of the triangles
    twin: np.ndarray  # (3 e,) index of the half-edge in the opposite direction on the same edge
    valence: np.ndarray  # (n,) number of neighbours of each node
    ring: np.ndarray  # (3 e, v) neighbours of a half-edge's start node, in order from its end node; then the last one again
    out: np.ndarray  # (n,) index of a half-edge that starts at each node

    @property
    def neighbours(self) -> np.ndarray:
        """Neighbours of each node in order, shape (n, v); the last one is repeated."""
        return self.ring[self.out]

    @property
    def begin(self) -> np.ndarray:
        """Node at which each half-edge starts, shape (3 e,)."""
        return self.triangles.ravel()

    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """Return for each edge the indices of one of its half-edges and of its half-edge in the opposite direction, shape
        (edges,) each."""
        one = np.flatnonzero(np.arange(len(self.twin)) < self.twin)
        return one, self.twin[one]


def rings(triangles: np.ndarray, n: int) -> Rings:
    """Build the one-rings of the n nodes of triangles, shape (e, 3).

    Raises ValueError if the surface is not closed, or if the triangles at a node form more than one fan.
    """
    edge = directed_edges(triangles).reshape(3, -1, 2).swapaxes(0, 1).reshape(-1, 2)
    code, back = edge[:, 0] * n + edge[:, 1], edge[:, 1] * n + edge[:, 0]
    order = np.argsort(code, kind="stable")
    place = np.minimum(np.searchsorted(code[order], back), len(code) - 1)
    twin = order[place]
    if not np.array_equal(code[twin], back) or (np.diff(code[order]) == 0).any():
        raise ValueError(
            "the surface is not closed or not consistently oriented: "
            "each edge must belong to two triangles, once in each direction"
        )
    valence = np.bincount(triangles.ravel(), minlength=n)
    out = np.full(n, -1, np.int64)
    out[edge[::-1, 0]] = np.arange(len(edge))[::-1]
    number = np.arange(len(edge))
    before = number - number % 3 + (number + 2) % 3  # the previous half-edge of the same triangle
    ring, around, turns = np.zeros((len(edge), valence.max()), np.int64), number, valence[edge[:, 0]]
    for k in range(ring.shape[1]):
        ring[:, k] = edge[around, 1]
        around = np.where(k < turns - 1, twin[before[around]], around)
    if (out < 0).any() or not np.array_equal(twin[before[around]], number):
        raise ValueError("the triangles at a node form more than one fan, or a node has no triangle")
    return Rings(triangles, twin, valence, ring, out)
