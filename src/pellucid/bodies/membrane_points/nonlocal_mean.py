"""The nonlocal mean of a field of membrane points over a radius of the initial surface.

Weights are (1 - r²/R²)² times the area share of the neighbour, divided by their sum, with the straight distance r at the
start: Pijaudier-Cabot & Bažant 1987, J. Eng. Mech. 113, 1512; the bell function of Bažant & Ožbolt 1990, J. Eng. Mech. 116,
2485. All arrays are in the order of point numbers, independent of sorting, and each sum has a fixed order: results are
bitwise equal for any number of threads.
"""

from typing import NamedTuple

import numpy as np
from numpy import uintp
from scipy.spatial import cKDTree

from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop

CHUNK = 256  # points that a thread processes at a time


class Neighbours(NamedTuple):
    """The neighbours of n points within the radius of a nonlocal mean, the weights of the mean, and its argument and
    result: the local field and the weighted means."""

    start: np.ndarray  # (n + 1,) index in `neighbour` of the first neighbour of each point
    neighbour: np.ndarray  # numbers of the neighbours, point by point
    weight: np.ndarray  # weights of the neighbours; their sum is 1 for each point
    local: np.ndarray  # (n,) the field to be averaged
    mean: np.ndarray  # (n,) the weighted means


@parallel_loop()
def _mean(chunk, about):
    start, neighbour, weight, local, mean = about.start, about.neighbour, about.weight, about.local, about.mean
    for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mean))):
        total = 0.0
        for k in range(start[i], start[i + 1]):
            total += weight[k] * local[uintp(neighbour[k])]
        mean[i] = total


class NonlocalMean:
    """Computes weighted means of a field over a radius [m] around n points with initial positions [m], shape (n, 3), and areas
    [m²], shape (n,).

    Callers write the field to `local`; `update` computes `mean`. Both have the shape (n,), in the order of point numbers.
    """

    def __init__(self, position: np.ndarray, area: np.ndarray, radius: float) -> None:
        n = len(position)
        pairs = cKDTree(position).query_pairs(radius, output_type="ndarray").astype(np.int32)
        itself = np.arange(n, dtype=np.int32)
        owner = np.concatenate([pairs[:, 0], pairs[:, 1], itself])
        neighbour = np.concatenate([pairs[:, 1], pairs[:, 0], itself])
        order = np.lexsort((neighbour, owner))
        owner, neighbour = owner[order], neighbour[order]
        squared = ((position[neighbour] - position[owner]) ** 2).sum(axis=1) / radius**2
        weight = (1.0 - np.minimum(squared, 1.0)) ** 2 * area[neighbour]
        weight /= np.bincount(owner, weight, minlength=n)[owner]
        self.local, self.mean = np.zeros(n), np.zeros(n)
        start = np.searchsorted(owner, np.arange(n + 1))
        self._neighbours = Bundle(Neighbours(start, neighbour, weight, self.local, self.mean))

    def update(self) -> None:
        """Compute the weighted means `mean` of the present values of the field `local`."""
        _mean((len(self.mean) + CHUNK - 1) // CHUNK, self._neighbours)
