"""Grids that are periodic along some axes: on a periodic axis of n cells, nodes i and i + n are identical.

No data is copied from one end to the other. A stencil numbers its nodes beyond the last one, and a table maps each such
number to the identical node within the grid. Each contribution of a point is therefore added once, in the order of slabs,
wherever the seam lies. Points move on across the seam without a jump: their positions show how often they crossed it, and
lengths, normals and displacements need no correction. A position is folded into the box only where it is converted to a
place on the grid.
"""

from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy import floor, uintp

from pellucid.jit import generic, point_function, pointwise


class Walled(NamedTuple):
    """Value of `Lattice.folding` for a grid without periodic axes, on which no two nodes are identical; selects functions
    that leave node indices and positions unchanged."""


class Folded(NamedTuple):
    """Value of `Lattice.folding` for a grid with at least one periodic axis: the periods, and the table that maps each
    stored node beyond a period to the identical node within the period."""

    real: np.ndarray  # (nodes,) index of the identical node within the period
    periods: tuple[float, float, float]  # period along each axis [cells], infinite along other axes
    cells: tuple[int, int, int]  # number of cells in a period, 0 along other axes
    steps: tuple[int, int, int]  # offset in memory between identical nodes, 0 along other axes


@generic
def real_node(folding: Any, I: int) -> Any:
    """Return the storage index of node I of a stencil (the nodes whose shape functions reach a point): I itself, or on a
    periodic axis the identical node within the period; folding: `Walled` or `Folded`."""


@generic
def in_period(folding: Any, axis: int, u: float) -> Any:
    """Return the coordinate u along an axis [cells from the lower end], folded into the box if the axis is periodic; folding:
    `Walled` or `Folded`."""


@generic
def cell_in_period(folding: Any, axis: int, i: int) -> Any:
    """Return the index i of a cell along an axis, folded into the box if the axis is periodic; folding: `Walled` or
    `Folded`."""


@generic
def cells_beyond(folding: Any, axis: int) -> Any:
    """Return the number of neighbours beyond a cell at the end of an axis: 1 if the axis is periodic, else 0; folding: `Walled`
    or `Folded`."""


@generic
def beyond_span(folding: Any, axis: int, u: float, low: float, high: float) -> Any:
    """Return 1.0 if a position u along an axis [cells from the lower end], folded into the box or not, lies outside the range
    low <= u < high, else 0.0; folding: `Walled` or `Folded`."""


@generic
def nodes_before(folding: Any, lattice: Any, I: int, a: int, b: int, c: int) -> Any:
    """Return the storage index of the node that lies a, b, c nodes before node I along the axes x, y, z; negative if there is
    none; folding: `Walled` or `Folded`."""


@generic
def seen_from(folding: Any, lattice: Any, about: Any, x: Any, a: int, b: int, c: int) -> Any:
    """Return the position x [m] in coordinates shared by all points that contribute to node (a, b, c) of a stencil: x itself on
    a walled grid, relative to the node on a periodic grid.

    about: the `Stencil` of the point at x; a, b, c: indices along x, y, z from its first node. folding: `Walled` or `Folded`.
    """


@point_function(real_node, Walled)
def _itself(folding, I):
    return uintp(I)


@point_function(real_node, Folded)
def _real(folding, I):
    return uintp(folding.real[uintp(I)])


@point_function(in_period, Walled)
def _as_it_is(folding, axis, u):
    return u


@pointwise
def _along(numbers, axis):
    return numbers[0] if axis == 0 else (numbers[1] if axis == 1 else numbers[2])


@point_function(in_period, Folded)
def _folded(folding, axis, u):
    n = _along(folding.periods, axis)
    return u - n * floor(u / n) if n < inf else u


@point_function(cell_in_period, Walled)
def _same_cell(folding, axis, i):
    return i


@point_function(cell_in_period, Folded)
def _folded_cell(folding, axis, i):
    n = _along(folding.cells, axis)
    return (i + n) % n if n > 0 else i


@point_function(cells_beyond, Walled)
def _none_beyond(folding, axis):
    return 0


@point_function(cells_beyond, Folded)
def _one_beyond(folding, axis):
    return 1 if _along(folding.cells, axis) > 0 else 0


@point_function(beyond_span, Walled)
def _beyond(folding, axis, u, low, high):
    beyond = 1.0 if u < low else 0.0
    return 1.0 if u >= high else beyond


@point_function(beyond_span, Folded)
def _beyond_folded(folding, axis, u, low, high):
    n = _along(folding.periods, axis)
    beyond = 1.0 if u < low else 0.0
    beyond = 1.0 if u >= high else beyond
    r = u - low
    around = 1.0 if r - n * floor(r / n) >= high - low else 0.0
    return around if n < inf else beyond


@point_function(nodes_before, Walled)
def _before(folding, lattice, I, a, b, c):
    stride = lattice.strides
    return I - a * stride[0] - b * stride[1] - c * stride[2]


@pointwise
def _index_along(lattice, I, axis):
    """Return the index of a node along an axis (0, 1, 2 for x, y, z) from its storage index I."""
    s, slow = lattice.strides, lattice.slab_axis
    middle = 1 if slow == 0 else 0  # the order of the axes in memory
    rest = I if axis == slow else I % _along(s, slow)
    rest = rest if axis in (slow, middle) else rest % _along(s, middle)
    return rest // _along(s, axis)


@point_function(nodes_before, Folded)
def _before_folded(folding, lattice, I, a, b, c):
    first = I
    for axis, by in ((0, a), (1, b), (2, c)):
        first -= by * _along(lattice.strides, axis)
        if _index_along(lattice, I, axis) < by:
            first += _along(folding.steps, axis)
    return first


@point_function(seen_from, Walled)
def _seen(folding, lattice, about, x, a, b, c):
    return x


@point_function(seen_from, Folded)
def _seen_from_node(folding, lattice, about, x, a, b, c):
    o, h = about.offset, -lattice.cell
    return h * (o[0] + 1.0 * a), h * (o[1] + 1.0 * b), h * (o[2] + 1.0 * c)
