"""Nodes beyond the ends of an axis: identical nodes of periodic axes, and mirror images at planes of symmetry.

**Periodic axes.** On a periodic axis of n cells, nodes i and i + n are identical.

No data is copied from one end to the other. A stencil numbers its nodes beyond the last one, and a table maps each such
number to the identical node within the grid. Each contribution of a point is therefore added once, in the order of slabs,
wherever the seam lies. Points move on across the seam without a jump: their positions show how often they crossed it, and
lengths, normals and displacements need no correction. A position is folded into the box only where it is converted to a
place on the grid.

**Planes of symmetry.** A face of the grid that is a plane of symmetry mirrors the fields on the grid. A stencil numbers its
node beyond the face, whose mirror image lies as far within the grid. Nodal scalars have the same value at both nodes, and so
have the components of vectors along the face; the component along the normal of the face has the other sign, since the face is
at rest. Values that points contribute to a node beyond the face are therefore added to its mirror image, the normal component
with the other sign. Twice this component is added to the node on the face between the two: it is what the face exerts. So the
sum over the nodes is that over the points, and the support that holds the face counts it.
"""

from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy import floor, uintp

from pellucid.jit import default_function, generic, point_function, pointwise


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


class Mirrored(NamedTuple):
    """Value of `Lattice.folding` for a grid with planes of symmetry at some faces. The tables have a row for each node that a
    stencil can number, also beyond the faces; the row of a node is its number plus `shift`."""

    within: Any  # `Walled`, or `Folded` if the grid is also periodic along some axes
    shift: int  # number of rows before that of node 0
    real: np.ndarray  # (rows,) index of the node itself, of the identical node within the period, or of the mirror image
    sign: np.ndarray  # (4 rows,) factors of the components of vectors, -1 along the normals of the faces, and of scalars
    face: np.ndarray  # (rows, 3) node on the face between the node and its image along each axis; -1 if there is none
    beyond: np.ndarray  # (rows,) 1 for a node beyond a plane of symmetry
    first: np.ndarray  # (rows,) next node within the grid, for the first node of a stencil
    reaches: np.ndarray  # (rows,) 1 for the first node of a stencil that contains nodes beyond a plane of symmetry
    planes: tuple[tuple[int, int], tuple[int, int], tuple[int, int]]  # for each axis 1 if its lower, upper face is a plane
    counts: tuple[int, int, int]  # number of cells along x, y, z


@generic
def real_node(folding: Any, I: int) -> Any:
    """Return the storage index of node I of a stencil (the nodes whose shape functions reach a point): I itself, or on a
    periodic axis the identical node within the period; folding: see `Lattice`."""


@generic
def first_node_within(folding: Any, number: int) -> Any:
    """Return the storage index of the first node of a stencil that has this number; beyond a plane of symmetry that of the next
    node within the grid; folding: `Walled`, `Folded` or `Mirrored`."""


@generic
def component_at(folding: Any, field: Any, number: Any, d: int) -> Any:
    """Return component d of a nodal vector field, shape (nodes, 3), at the node with this number in a stencil; folding:
    `Walled`, `Folded` or `Mirrored`."""


@generic
def add_to_component(folding: Any, field: Any, number: Any, d: int, value: Any) -> Any:
    """Add a value to component d of a nodal vector field, shape (nodes, 3), at the node with this number in a stencil; folding:
    `Walled`, `Folded` or `Mirrored`."""


@generic
def add_to_number(folding: Any, rows: Any, number: Any, d: int, value: Any) -> Any:
    """Add a value to component d, 0 to 2, of nodal rows, shape (4 nodes,), at the node with this number in a stencil; folding:
    see `Lattice`."""


@generic
def _mirrored_place(folding: Any, x: Any, to_node: Any, cell: float) -> Any:
    """Return the mirror image of a coordinate x that `seen_from` returned [m], for a node beyond a plane of symmetry; to_node:
    coordinate of the node minus that of the point [m]; cell: edge of a cell [m]; folding: `Walled` or `Folded`."""


@generic
def in_period(folding: Any, axis: int, u: float) -> Any:
    """Return the coordinate u along an axis [cells from the lower end], folded into the box if the axis is periodic; folding:
    `Walled` or `Folded`."""


@generic
def cell_in_period(folding: Any, axis: int, i: int) -> Any:
    """Return the index i of a cell along an axis, folded into the box if the axis is periodic; folding: see
    `Lattice`."""


@generic
def cells_beyond(folding: Any, axis: int) -> Any:
    """Return the number of neighbours beyond a cell at the end of an axis: 1 if the axis is periodic, else 0; folding: `Walled`
    or `Folded`."""


@generic
def beyond_span(folding: Any, axis: int, u: float, low: float, high: float) -> Any:
    """Return 1.0 if a position u along an axis [cells from the lower end], folded into the box or not, lies outside the range
    low <= u < high, else 0.0; folding: see `Lattice`."""


@generic
def nodes_before(folding: Any, lattice: Any, I: int, a: int, b: int, c: int) -> Any:
    """Return the storage index of the node that lies a, b, c nodes before node I along the axes x, y, z; negative if there is
    none; folding: see `Lattice`."""


@generic
def seen_from(folding: Any, lattice: Any, about: Any, x: Any, a: int, b: int, c: int) -> Any:
    """Return the position x [m] in coordinates shared by all points that contribute to node (a, b, c) of a stencil: x itself on
    a walled grid, relative to the node on a periodic grid; for a node beyond a plane of symmetry, the mirror image of x.

    about: the `Stencil` of the point at x; a, b, c: indices along x, y, z from its first node. folding: `Walled`, `Folded` or
    `Mirrored`.
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


@default_function(first_node_within)
def _first_itself(folding, number):
    return number


@point_function(first_node_within, Mirrored)
def _first_within(folding, number):
    return folding.first[uintp(number + folding.shift)]


@point_function(real_node, Mirrored)
def _image(folding, I):
    return uintp(folding.real[uintp(I + folding.shift)])


@pointwise
def reaches_images(folding, first_node, n):
    """Return True if the stencil of one of n points contains a node beyond a plane of symmetry; first_node: numbers of the
    first nodes of the stencils; folding: a `Mirrored`."""
    reaches = 0
    for q in range(n):
        reaches |= folding.reaches[uintp(first_node[q] + folding.shift)]
    return reaches != 0


@default_function(component_at)
def _component(folding, field, number, d):
    return field[real_node(folding, number), d]


@point_function(component_at, Mirrored)
def _component_of_image(folding, field, number, d):
    q = uintp(number + folding.shift)
    return folding.sign[4 * q + d] * field[uintp(folding.real[q]), d]


@default_function(add_to_component)
def _add_to_component(folding, field, number, d, value):
    field[real_node(folding, number), d] += value


@point_function(add_to_component, Mirrored)
def _add_to_component_of_image(folding, field, number, d, value):
    q = uintp(number + folding.shift)
    field[uintp(folding.real[q]), d] += folding.sign[4 * q + d] * value
    if folding.face[q, d] >= 0:
        field[uintp(folding.face[q, d]), d] += 2.0 * value


@default_function(add_to_number)
def _add_to_number(folding, rows, number, d, value):
    rows[4 * real_node(folding, number) + d] += value


@point_function(add_to_number, Mirrored)
def _add_to_number_of_image(folding, rows, number, d, value):
    q = uintp(number + folding.shift)
    rows[4 * uintp(folding.real[q]) + d] += folding.sign[4 * q + d] * value
    if folding.face[q, d] >= 0:
        rows[4 * uintp(folding.face[q, d]) + d] += 2.0 * value


ON_PLANE = 1e-9
"""Distance beyond a plane of symmetry [cells], within which a point lies in it. The contributions of a node and of its mirror
image to the normal velocity in the plane cancel up to rounding, which adds up over the steps."""


@point_function(in_period, Mirrored)
def _in_period_within(folding, axis, u):
    n, (lower, upper) = _along(folding.counts, axis), _along(folding.planes, axis)
    if lower == 1 and u < 0.0 and u > -ON_PLANE:
        return 0.0
    return 1.0 * n if upper == 1 and u > n and u < n + ON_PLANE else in_period(folding.within, axis, u)


@point_function(cell_in_period, Mirrored)
def _cell_of_image(folding, axis, i):
    n, (lower, upper) = _along(folding.counts, axis), _along(folding.planes, axis)
    if lower == 1 and i < 0:
        return -1 - i
    return 2 * n - 1 - i if upper == 1 and i >= n else cell_in_period(folding.within, axis, i)


@point_function(cells_beyond, Mirrored)
def _cells_beyond_within(folding, axis):
    return cells_beyond(folding.within, axis)


@point_function(beyond_span, Mirrored)
def _beyond_within(folding, axis, u, low, high):
    return beyond_span(folding.within, axis, u, low, high)


@point_function(nodes_before, Mirrored)
def _before_within(folding, lattice, I, a, b, c):
    return nodes_before(folding.within, lattice, I, a, b, c)


@point_function(seen_from, Mirrored)
def _seen_as_image(folding, lattice, about, x, a, b, c):
    stride, o, h = lattice.strides, about.offset, lattice.cell
    face = folding.face[uintp(about.start + a * stride[0] + b * stride[1] + c * stride[2] + folding.shift)]
    x0, x1, x2 = seen_from(folding.within, lattice, about, x, a, b, c)
    x0 = _mirrored_place(folding.within, x0, (o[0] + 1.0 * a) * h, h) if face[0] >= 0 else x0
    x1 = _mirrored_place(folding.within, x1, (o[1] + 1.0 * b) * h, h) if face[1] >= 0 else x1
    x2 = _mirrored_place(folding.within, x2, (o[2] + 1.0 * c) * h, h) if face[2] >= 0 else x2
    return x0, x1, x2


@point_function(_mirrored_place, Walled)
def _mirrored(folding, x, to_node, cell):
    return x + 2.0 * (to_node + (cell if to_node < 0.0 else -cell))  # the face lies a cell from the node, towards the point


@point_function(_mirrored_place, Folded)
def _mirrored_from_node(folding, x, to_node, cell):
    return -x
