"""Feet of contact points on another surface: weighted means of the positions of its points.

Velocities of the other surface are interpolated to the feet. Forces on the feet are distributed to its points with the same
weights and therefore do the same work. Contact laws need no further data of the other surface, and feet on triangles have
the same form as feet between points.
"""

from typing import NamedTuple

import numpy as np

from pellucid.jit import kernel


class Feet(NamedTuple):
    """Feet of n contact points, i.e. their projections on another surface, as weighted means of its points. Foot i has
    the entries first[i] to first[i + 1] of `point` and `share`."""

    first: np.ndarray  # (n + 1,) start of the entries of each foot
    point: np.ndarray  # (k,) point numbers
    share: np.ndarray  # (k,) weights; their sum is 1 for each foot

    def gather(self, values: np.ndarray) -> np.ndarray:
        """Return values interpolated to the feet, shape (n, 3), from values at the points of the other surface, shape (q,
        3)."""
        found = np.zeros((len(self.first) - 1, 3))
        _gather(self.first, self.point, self.share, values, found)
        return found

    def spread(self, force: np.ndarray, into: np.ndarray) -> None:
        """Distribute forces on the feet [N], shape (n, 3), to the points of the other surface by adding them to `into`, the
        forces on these points [N], shape (q, 3)."""
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
