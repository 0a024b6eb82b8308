"""Feet of contact points on another surface: places between points of that, by their shares in it.

Velocities of the other surface are gathered at the feet, and forces on the feet are spread to its points by the same shares, so
that these forces do the work that they do at the feet. Contact laws need no more of the other surface: points between faces and
corners of triangles have the same feet.
"""

from typing import NamedTuple

import numpy as np

from pellucid.jit import kernel


class Feet(NamedTuple):
    """n feet and their shares in points of the other surface; those of foot i are first[i] to first[i + 1]."""

    first: np.ndarray  # (n + 1,)
    point: np.ndarray  # (k,)
    share: np.ndarray  # (k,) of each foot 1 in sum

    def gather(self, values: np.ndarray) -> np.ndarray:
        """Return means of values of the other surface's points, shape (q, 3), at the feet, shape (n, 3)."""
        found = np.zeros((len(self.first) - 1, 3))
        _gather(self.first, self.point, self.share, values, found)
        return found

    def spread(self, force: np.ndarray, into: np.ndarray) -> None:
        """Add forces on the feet [N], shape (n, 3), to those on the other surface's points, shape (q, 3)."""
        _spread(self.first, self.point, self.share, force, into)


@kernel()
def _gather(first, point, share, values, found):
    for i in range(len(found)):
        for r in range(first[i], first[i + 1]):
            for d in range(3):
                found[i, d] += share[r] * values[point[r], d]


@kernel()
def _spread(first, point, share, force, into):
    for i in range(len(force)):
        for r in range(first[i], first[i + 1]):
            for d in range(3):
                into[point[r], d] += share[r] * force[i, d]
