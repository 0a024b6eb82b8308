"""One-rings: the ordered neighbours of the nodes of a closed triangulation."""

from typing import NamedTuple

import numpy as np

from pellucid.geometry.meshes.triangulation import directed_edges


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
