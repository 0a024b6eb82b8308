"""Sorting points by cell and sharing them out in slabs."""

import numpy as np

from pellucid.grid.lattice import Lattice
from pellucid.grid.points import COLUMNS, Slabs
from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for

MOST_SLABS = 64
CHUNK = 4096  # points that a thread reorders at a time
EACH_SORTING = 2000.0
"""What sorting costs beside its share for each point, in vectors of points with the same nodes: 0.12 ms, at 65 ns a vector."""


@kernel()
def _order_by_cell(position, lattice, layer_count):
    """Stable counting sort: the order of the points by cell, and the number of points up to each layer of cells."""
    n, low, h, axis = lattice.counts, lattice.lower, lattice.inverse_cell, lattice.slab_axis
    second, third = (1 if axis == 0 else 0), (1 if axis == 2 else 2)
    cells = np.empty(len(position), np.int64)
    count = np.zeros(n[0] * n[1] * n[2] + 1, np.int64)
    for p in range(len(position)):
        i = min(int((position[p, axis] - low[axis]) * h), n[axis] - 1)
        j = min(int((position[p, second] - low[second]) * h), n[second] - 1)
        k = min(int((position[p, third] - low[third]) * h), n[third] - 1)
        cell = (i * n[second] + j) * n[third] + k
        cells[p] = cell
        count[cell + 1] += 1
        layer_count[i + 1] += 1
    for c in range(1, len(count)):
        count[c] += count[c - 1]
    for c in range(1, len(layer_count)):
        layer_count[c] += layer_count[c - 1]
    order = np.empty(len(position), np.int64)
    for p in range(len(position)):
        order[count[cells[p]]] = p
        count[cells[p]] += 1
    return order


@kernel()
def _reorder_rows(chunks, source, target, order):
    parallel_for(_reorder_chunk, chunks, source, target, order)


@kernel(inner=True)
def _reorder_chunk(chunk, source, target, order):
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(order))):
        for c in range(source.shape[1]):
            target[p, c] = source[order[p], c]


def sort_by_cell(arrays: dict[str, np.ndarray], scratch: dict[int, np.ndarray], lattice: Lattice, stencil: int) -> Slabs:
    """Sort every array of a body (first axis: points) by cell, in place, and cut the sorted points into slabs.

    scratch: kept by the body between calls, one array for each row width and type.
    """
    layers = np.zeros(lattice.counts[lattice.slab_axis] + 1, np.int64)
    order = _order_by_cell(arrays["position"], lattice, layers)
    if not np.array_equal(order, np.arange(len(order))):
        for array in arrays.values():
            rows = array.reshape(len(array), -1)
            key = rows.shape[1] if rows.dtype == np.float64 else -rows.shape[1]
            spare = scratch.setdefault(key, np.empty_like(rows))
            _reorder_rows((len(rows) + CHUNK - 1) // CHUNK, rows, spare, order)
            rows[...] = spare
    edges = _slab_edges(layers, 3 if stencil == 2 else 5)
    return empty_slabs(layers[edges], edges)


class ShortRuns:
    """What short runs of points with the same nodes have cost since the points of a body were sorted.

    The further the order of the points is from that by cell, the more vectors a pass over them takes. The vectors of each step
    beyond the fewest of any since the sorting are added up, and when they cost as much as a sorting, that pays: so both
    together cost at most twice what they would if one knew when to sort, and the least where the runs shorten evenly.
    """

    def __init__(self, n_points: int, cost: float) -> None:
        """cost: of a sorting, in vectors for each point."""
        self._price = cost * n_points + EACH_SORTING
        self.counts = np.array([0.0, n_points])
        """Vectors beyond the fewest, added up; the fewest in a step, which are no more than the points."""

    def add(self, vectors: float) -> None:
        """Count the vectors of a step."""
        self.counts[1] = min(self.counts[1], vectors)
        self.counts[0] += vectors - self.counts[1]

    @property
    def sorting_pays(self) -> bool:
        """Whether they have cost as much as a sorting."""
        return bool(self.counts[0] >= self._price)


def empty_slabs(first: np.ndarray, layer: np.ndarray) -> Slabs:
    """Slabs with nothing reported yet."""
    n = len(layer) - 1
    return Slabs(first, layer, np.zeros((n, 2), np.int64), np.zeros(n, np.int64), np.zeros((n, COLUMNS)))


def _slab_edges(layers: np.ndarray, width: int) -> np.ndarray:
    """Layers where slabs begin and end: each at least `width` layers, with shares of the points as equal as that allows."""
    total, n = layers[-1], len(layers) - 1
    most = max(min(MOST_SLABS, n // width), 1)
    edges = [0]
    for i in range(1, n):
        due = layers[i] * most >= len(edges) * total
        if due and i - edges[-1] >= width and n - i >= width:
            edges.append(i)
    return np.array([*edges, n], dtype=np.int64)
