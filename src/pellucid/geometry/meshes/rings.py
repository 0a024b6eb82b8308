"""The neighbours of the nodes of a closed triangulation, in their turn."""

from typing import NamedTuple

import numpy as np

from pellucid.geometry.meshes.triangulation import directed_edges


class Rings(NamedTuple):
    """Half-edge 3 t + k leads from corner k of triangle t to the next one; rings are counterclockwise about the normal."""

    triangles: np.ndarray  # (e, 3)
    twin: np.ndarray  # (3 e,) the half-edge that leads back
    valence: np.ndarray  # (n,) neighbours of each node
    ring: np.ndarray  # (3 e, v) those of the node a half-edge begins at, from its end on; the last one repeated
    out: np.ndarray  # (n,) a half-edge that begins at each node

    @property
    def neighbours(self) -> np.ndarray:
        """The neighbours of each node in their turn, shape (n, v); the last one is repeated."""
        return self.ring[self.out]

    @property
    def begin(self) -> np.ndarray:
        """The node that each half-edge begins at, shape (3 e,)."""
        return self.triangles.ravel()

    def edges(self) -> tuple[np.ndarray, np.ndarray]:
        """One half-edge of each edge, and the other half-edge of each, which leads back."""
        one = np.flatnonzero(np.arange(len(self.twin)) < self.twin)
        return one, self.twin[one]


def rings(triangles: np.ndarray, n: int) -> Rings:
    """The rings of n nodes. Raises ValueError where the triangles do not close, or meet at a node in more than one fan."""
    edge = directed_edges(triangles).reshape(3, -1, 2).swapaxes(0, 1).reshape(-1, 2)
    code, back = edge[:, 0] * n + edge[:, 1], edge[:, 1] * n + edge[:, 0]
    order = np.argsort(code, kind="stable")
    place = np.minimum(np.searchsorted(code[order], back), len(code) - 1)
    twin = order[place]
    if not np.array_equal(code[twin], back) or (np.diff(code[order]) == 0).any():
        raise ValueError("the triangles do not close, or turn different ways: every edge belongs to two, one in each direction")
    valence = np.bincount(triangles.ravel(), minlength=n)
    out = np.full(n, -1, np.int64)
    out[edge[::-1, 0]] = np.arange(len(edge))[::-1]
    number = np.arange(len(edge))
    before = number - number % 3 + (number + 2) % 3  # the half-edge that ends where this one begins
    ring, around, turns = np.zeros((len(edge), valence.max()), np.int64), number, valence[edge[:, 0]]
    for k in range(ring.shape[1]):
        ring[:, k] = edge[around, 1]
        around = np.where(k < turns - 1, twin[before[around]], around)
    if (out < 0).any() or not np.array_equal(twin[before[around]], number):
        raise ValueError("the triangles about a node are more than one fan, or a node has none")
    return Rings(triangles, twin, valence, ring, out)
