"""Sorting of points by the nodes that they reach, and their division into slabs."""

from collections.abc import Mapping
from functools import cache

import numpy as np

from pellucid.approximants import GridFunction, GridFunctions, PeriodicAxis
from pellucid.approximants.grid_functions import axis_numbers
from pellucid.errors import UsageError
from pellucid.grid.lattice import MOST_ROWS, Grid, Lattice, row_edges
from pellucid.grid.points import COLUMNS, Slabs
from pellucid.jit import kernel
from pellucid.jit.loops import parallel_loop
from pellucid.ranks.domain import Rows, domain

MOST_SLABS = 256
FEWEST_CELLS = 120  # in a slab of a row that is cut: of fewer, what it costs beside its points counts
CHUNK = 4096  # points that a thread reorders at a time
EACH_SORTING = 2000.0
"""Fixed cost of a sorting in addition to the cost per point, in vectors of points with the same nodes: 0.12 ms at 65 ns per
vector."""


@kernel()
def _order_by_nodes(position, functions, lattice, layers, across, slab, cut, nodes, count, first, order):
    """Compute the order of the points by slab, and within a slab by their first node (stable counting sort), in `order`, and
    the first point of each slab in `first`.

    position: [m], shape (points, 3); functions: shape functions along x, y, z. There are as many first nodes along an axis
    as cells. layers, across: see `Slabs`; slab, cut: the row of slabs of each layer, and the piece of a row of each layer
    along the axis of the cuts. Scratch arrays: nodes, shape (points,); count, zeros, shape (cells + 1,).
    """
    n, low, h, main, second = lattice.counts, lattice.lower, lattice.inverse_cell, lattice.slab_axis, lattice.cut_axis
    third = 3 - main - second
    for p in range(len(position)):
        i, _ = axis_numbers(functions[0], (position[p, 0] - low[0]) * h, n[0])
        j, _ = axis_numbers(functions[1], (position[p, 1] - low[1]) * h, n[1])
        k, _ = axis_numbers(functions[2], (position[p, 2] - low[2]) * h, n[2])
        a = max(int(i if main == 0 else (j if main == 1 else k)), 0)  # -1 beyond a plane of symmetry
        b = max(int(i if second == 0 else (j if second == 1 else k)), 0)
        c = max(int(i if third == 0 else (j if third == 1 else k)), 0)
        within = layers[slab[a] * across + cut[b]]
        rows = within[0] * n[second] + (within[1] - within[0]) * within[2]  # of cells along the third axis, in slabs before
        nodes[p] = (rows + (a - within[0]) * (within[3] - within[2]) + b - within[2]) * n[third] + c
        count[nodes[p] + 1] += 1
    for c in range(1, len(count)):
        count[c] += count[c - 1]
    for s in range(len(layers)):
        within = layers[s]
        first[s] = count[(within[0] * n[second] + (within[1] - within[0]) * within[2]) * n[third]]
    first[len(layers)] = len(position)
    for p in range(len(position)):
        order[count[nodes[p]]] = p
        count[nodes[p]] += 1


@kernel()
def _find_layers(position, function, lattice, layer):
    """Compute the layer of the first node of each point along the axis of the slabs, in `layer`, shape (points,).

    position: [m], shape (points, 3); function: shape function along this axis.
    """
    axis = lattice.slab_axis
    for p in range(len(position)):
        offset = (position[p, axis] - lattice.lower[axis]) * lattice.inverse_cell
        first, _ = axis_numbers(function, offset, lattice.counts[axis])
        layer[p] = max(int(first), 0)  # -1 beyond a plane of symmetry


@parallel_loop()
def _reorder_rows(chunk, source, target, order):
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(order))):
        for c in range(source.shape[1]):
            target[p, c] = source[order[p], c]


def sort_by_nodes(
    arrays: dict[str, np.ndarray], spare: np.ndarray, lattice: Lattice, functions: GridFunctions, slabs: Slabs
) -> np.ndarray:
    """Sort every array of a body (first axis: points) in place by the first node of each point, and divide the sorted
    points among the slabs (blocks of grid cells).

    arrays: by name, with "position"; functions: shape functions along x, y, z; spare: scratch memory for the rows of one
    array. Returns scratch memory for the next call, enlarged if it was too small. With trilinear functions this sorts by
    cell; with other functions the first node changes in the middle of a cell.
    """
    layers, across, (slab, cut) = _layers_of(lattice, functions)
    points, cells = len(arrays["position"]), int(np.prod(lattice.counts))
    nodes, order, count = np.empty(points, np.int64), np.empty(points, np.int64), np.zeros(cells + 1, np.int64)
    _order_by_nodes(arrays["position"], functions, lattice, layers, across, slab, cut, nodes, count, slabs.first, order)
    if not np.array_equal(order, np.arange(points)):
        for array in arrays.values():
            rows = array.reshape(points, -1).view(np.int64)  # one kernel for all types, of eight bytes each
            if spare.size < rows.size:
                spare = np.empty(rows.size, np.int64)
            unsorted = spare[: rows.size].reshape(rows.shape)
            unsorted[...] = rows
            _reorder_rows((points + CHUNK - 1) // CHUNK, unsorted, rows, order)
    _report_nothing(slabs)
    return spare


class ShortRuns:
    """Computing time lost since the last sorting because points that share their nodes are no longer neighbours in memory
    (short runs), in numbers of vectors; a body uses this cost to decide when to sort again.

    The less the points are ordered by their nodes, the more vectors a pass processes. In each step, the number of vectors
    beyond the smallest number since the last sorting is added up. Sorting pays when these vectors cost as much as a
    sorting. The total cost is then at most twice the optimum, and equals the optimum if the runs shorten evenly.
    """

    def __init__(self, n_points: int, cost: float) -> None:
        """n_points: number of points; cost: computing time of a sorting, in units of the time of a vector of points, per
        point."""
        self._price = cost * n_points + EACH_SORTING
        self.counts = np.array([0.0, n_points])
        """Array of two numbers: the sum of the vectors beyond the smallest number, and the smallest number of vectors in a
        step, at most the number of points."""

    def add(self, vectors: float) -> None:
        """Record the number of vectors (groups of points with the same nodes, processed together) that a pass processed in
        a step."""
        self.counts[1] = min(self.counts[1], vectors)
        self.counts[0] += vectors - self.counts[1]

    @property
    def sorting_pays(self) -> bool:
        """Return True if the time lost by unsorted points since the last sorting exceeds the time of a sorting."""
        return bool(self.counts[0] >= self._price)


def slabs_of(lattice: Lattice, functions: GridFunctions) -> Slabs:
    """Build slabs (blocks of grid cells) without points and without reported faults.

    The s nodes of a point along an axis lie half on either side of the point: its first node is i if its coordinate is
    between i + shift and i + 1 + shift, with shift = s/2 - 1 [cells]. With GIMP the half edge of a point, at most ½,
    replaces ½.

    Two slabs of one colour reach no common node: points of the layers [a, b) stay between a - 1 + shift and b + 1 + shift,
    so their nodes lie between a - 1 and b + s - 1, or b + s with GIMP. The slab between two slabs of one colour has at
    least `width` layers, so the nodes of the next one begin at b + width - 1. Sufficient widths are 3 layers for s = 2, and
    5 for s = 4 and for s = 3 with GIMP. functions: shape functions along x, y, z.
    """
    layers, across, _ = _layers_of(lattice, functions)
    n, shifts = len(layers), [0.5 * functions[axis].stencil - 1.0 for axis in (lattice.slab_axis, lattice.cut_axis)]
    bounds = layers + np.array([shifts[0] - 1.0, shifts[0] + 1.0, shifts[1] - 1.0, shifts[1] + 1.0])
    if across == 1:
        bounds[:, 2:] = -np.inf, np.inf
    first = np.zeros(n + 1, np.int64)
    faults, left, (sums, of_lost) = np.zeros((n, 2), np.int64), np.zeros(n, np.int64), np.zeros((2, n, COLUMNS))
    return Slabs(first, layers, across, bounds, faults, left, sums, of_lost)


def rows_of(grid: Grid, functions: GridFunctions) -> Rows:
    """Return the division of the grid into rows of slabs (blocks of grid cells), the same for all bodies; functions: shape
    functions along x, y, z."""
    lattice = grid.lattice
    layers, across, _ = _layers_of(lattice, functions)
    edges = np.append(layers[::across, 0], layers[-1, 1])
    stencil = max(function.stencil for function in functions)
    return Rows(edges, across, stencil, lattice.strides[lattice.slab_axis], grid.n_nodes)


def points_here(lattice: Lattice, functions: GridFunctions, position: np.ndarray) -> np.ndarray:
    """Return, in ascending order, the indices of those positions [m], shape (n, 3), that lie in the rows of slabs (blocks
    of grid cells) of this process; functions: shape functions along x, y, z."""
    if not domain.is_cut:
        return np.arange(len(position))
    layer = np.empty(len(position), np.int64)
    _find_layers(position, functions[lattice.slab_axis], lattice, layer)
    return np.flatnonzero(domain.has_layer(layer))


def kept_of(slabs: Slabs) -> dict[str, np.ndarray]:
    """Return the arrays of a division into slabs (blocks of grid cells, see `Slabs`), by name, for a checkpoint."""
    return {"first": slabs.first, "left_slab": slabs.left_slab, "layers": slabs.layers}


def restore_slabs(slabs: Slabs, kept: Mapping[str, np.ndarray]) -> None:
    """Restore a division into slabs (blocks of grid cells) from the arrays `kept` of a checkpoint. Raises UsageError if the
    arrays belong to another division, e.g. of an earlier version."""
    if not np.array_equal(kept["layers"], slabs.layers):
        text = "the checkpoint was written by another version of pellucid (with other slabs)"
        raise UsageError(f"{text}: resume with that version, or start the run again")
    _report_nothing(slabs)
    slabs.first[:], slabs.left_slab[:] = kept["first"], kept["left_slab"]


def _report_nothing(slabs: Slabs) -> None:
    """Reset the faults and sums of `slabs` to zero: kernels skip slabs (blocks of grid cells) without points and would
    leave the values of earlier points."""
    for reported in (slabs.left_slab, slabs.fault, slabs.sums, slabs.of_lost):
        reported.fill(0)


Divided = tuple[np.ndarray, int, list[np.ndarray]]


def _layers_of(lattice: Lattice, functions: GridFunctions) -> Divided:
    """Return the layers of each slab, shape (slabs, 4), and the number of slabs in a row (see `Slabs`), and for both axes the
    row or piece to which each layer belongs. The division is the same for all bodies at any position, with slabs as narrow
    as two colours allow.

    functions: shape functions along x, y, z.
    """
    axes = tuple((lattice.counts[axis], functions[axis]) for axis in (lattice.slab_axis, lattice.cut_axis))
    return _divided(axes, int(np.prod(lattice.counts)))


@cache
def _divided(axes: tuple[tuple[int, GridFunction], ...], cells: int) -> Divided:
    """Return the division of a grid into slabs, which `_layers_of` describes. axes: a pair (number of layers of cells, shape
    function) for the slowest axis, along which rows of slabs follow each other, and for the axis along which a row is cut
    into pieces; cells: total number of cells."""
    edges, most = [], MOST_ROWS
    for count, function in axes:
        edges.append(row_edges(count, function.stencil, most, isinstance(function, PeriodicAxis)))
        most = min(cells // FEWEST_CELLS, MOST_SLABS) // (len(edges[-1]) - 1)
    rows, pieces = (np.stack([ends[:-1], ends[1:]], axis=1) for ends in edges)
    layers = np.concatenate([np.repeat(rows, len(pieces), axis=0), np.tile(pieces, (len(rows), 1))], axis=1)
    return layers, len(pieces), [np.repeat(np.arange(len(ends) - 1), np.diff(ends)) for ends in edges]
