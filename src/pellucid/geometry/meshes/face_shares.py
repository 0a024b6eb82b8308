"""How forces on faces are shared among nodes."""

from typing import NamedTuple

import numpy as np


class FaceShares(NamedTuple):
    """Shares of nodes in what acts evenly on faces: the means of their functions over each, which add up to one there."""

    face: np.ndarray  # (m,) place among the faces asked for
    node: np.ndarray  # (m,)
    share: np.ndarray  # (m,)

    @classmethod
    def linear(cls, faces: np.ndarray) -> "FaceShares":
        """The shares of linear functions of the corners of triangles, shape (f, 3)."""
        n = 3 * len(faces)
        return cls(np.repeat(np.arange(len(faces)), 3), faces.ravel(), np.full(n, 1.0 / 3.0))

    def of(self, chosen: np.ndarray) -> "FaceShares":
        """Those in some of the faces alone; chosen: shape (f,), whether it is one of these."""
        kept, number = chosen[self.face], np.cumsum(chosen) - 1
        return FaceShares(number[self.face[kept]], self.node[kept], self.share[kept])

    def at_nodes(self, on_faces: np.ndarray, n: int) -> np.ndarray:
        """Sums at n nodes, shape (n, 3), of shares in vectors on the faces, shape (f, 3), in the order of the faces."""
        parts = self.share[:, None] * on_faces[self.face]
        return np.stack([np.bincount(self.node, parts[:, axis], n) for axis in range(3)], axis=1)
