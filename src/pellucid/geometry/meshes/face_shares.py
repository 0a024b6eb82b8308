"""Distribution of forces on faces to the nodes of the faces."""

from typing import NamedTuple

import numpy as np


class FaceShares(NamedTuple):
    """Fractions of an evenly distributed face load that each node receives: the mean of its shape function over the face.

    The fractions of a face add up to 1.
    """

    face: np.ndarray  # (m,) index of the face
    node: np.ndarray  # (m,) index of the node
    share: np.ndarray  # (m,) fraction of the load on the face that the node receives

    @classmethod
    def linear(cls, faces: np.ndarray) -> "FaceShares":
        """Return the fractions for linear shape functions (a third of the load for each corner) on triangles, given as node
        numbers, shape (f, 3)."""
        n = 3 * len(faces)
        return cls(np.repeat(np.arange(len(faces)), 3), faces.ravel(), np.full(n, 1.0 / 3.0))

    def of(self, chosen: np.ndarray) -> "FaceShares":
        """Return the fractions on the chosen faces only; chosen: mask of the faces, shape (f,)."""
        kept, number = chosen[self.face], np.cumsum(chosen) - 1
        return FaceShares(number[self.face[kept]], self.node[kept], self.share[kept])

    def at_nodes(self, on_faces: np.ndarray, n: int) -> np.ndarray:
        """Return the sums at n nodes, shape (n, 3), of vectors on the faces such as forces (`on_faces`, shape (f, 3)),
        distributed by their fractions."""
        parts = self.share[:, None] * on_faces[self.face]
        return np.stack([np.bincount(self.node, parts[:, axis], n) for axis in range(3)], axis=1)
