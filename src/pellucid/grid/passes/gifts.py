"""P2G of values (weighted by N) or of rows of values (weighted by the gradients of N).

Linear functions have the same gradients at all points with the same nodes. The contributions of such a run of points are
therefore summed first: by N one row per node; by gradients one row per line of nodes along an axis, using the products of
the transverse weights. The nodes are then updated once per run. With other functions each point adds separately.

A contribution ("gift") is a NamedTuple whose rule has a function `given`, which returns the values of one point. All nodal
rows have four numbers.
"""

from typing import Any, NamedTuple

import numpy as np
from numpy import uintp

from pellucid.approximants.grid_functions import CurvedFunctions, LinearFunctions
from pellucid.grid.folded_rows import add_to_row
from pellucid.grid.folding import Mirrored, reaches_images
from pellucid.grid.lattice import without_images
from pellucid.grid.passes.blocks import about_point, expect, fetch, find_functions, functions_like
from pellucid.grid.points import MappedPoints, place_of
from pellucid.grid.stencil import node_at, number_at, number_behind
from pellucid.jit import default_function, generic, kernel, point_function, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.calls import call_kernel
from pellucid.jit.columns import BLOCK, WIDTH, no_sums, outer, plus, put, size, take
from pellucid.jit.loops import joint_by_colour, joint_region
from pellucid.jit.memory import indices, numbers
from pellucid.jit.vector import LANES, load, row, store
from pellucid.tensors import ZERO_VECTOR

LINES, WEIGHTS = 8, 20
"""Layout of the columns of weights for a run of points: first the weights of at most eight nodes; from LINES on, the products
of transverse weights for lines of nodes along each axis, at most four per axis."""
FIRST, SECOND = 1, 2
"""Bits that select the first and the second of two contributions."""


class Nothing(NamedTuple):
    """Value of `GivingPoints.gives` for a pass (a loop over points) whose points contribute nothing to the grid nodes."""


class ByValue(NamedTuple):
    """Contribution of points to each of their nodes: a row of four values times the node's shape function N."""

    rule: Any  # kind of contribution, whose type selects `given`
    read: Any  # point arrays that `given` reads
    read_like: Any  # example of the values of one point in `read`
    into: np.ndarray  # (4 nodes,) rows


class BySlope(NamedTuple):
    """Contribution of points to each of their nodes with the shape function N: Σ_d row_d ∂N/∂x_d, with one row of four
    values for each axis d."""

    rule: Any  # kind of contribution, whose type selects `given`
    read: Any  # point arrays that `given` reads
    read_like: Any  # example of the values of one point in `read`
    into: np.ndarray  # (4 nodes,) rows


class BySquare(NamedTuple):
    """Contribution of the volumes V of points to each of their nodes with the shape function N: V Σ_e k (∂N/∂x_e)² for each
    axis d, with k = factors[1] if e = d, else factors[0]."""

    volume: np.ndarray  # (n,) [m³]
    factors: np.ndarray  # (2,) factors k of the derivatives along other axes than d, and along d
    into: np.ndarray  # (4 nodes,) nodal rows of four numbers, to which the contribution is added


class Both(NamedTuple):
    """Two contributions of the same points to the grid nodes."""

    first: Any  # `ByValue`, `BySlope` or `BySquare`
    second: Any  # `ByValue`, `BySlope` or `BySquare`


class GivingPoints(NamedTuple):
    """Points of a body and their contribution to the nodes (`ByValue`, `BySlope`, `BySquare` or `Both`)."""

    mapped: Bundle  # of `MappedPoints`
    gives: Any  # `ByValue`, `BySlope`, `BySquare` or `Both`


def example_of(arrays: Any) -> Any:
    """Return a value of one point in (nested tuples of) arrays, filled with zeros, from which kernels take the types: a number,
    or (nested) tuples of numbers."""
    if isinstance(arrays, tuple):
        parts = [example_of(array) for array in arrays]
        return type(arrays)(*parts) if hasattr(arrays, "_fields") else tuple(parts)
    return (0.0,) * arrays.shape[1] if arrays.ndim == 2 else 0.0


def by_value(rule: Any, read: Any, into: np.ndarray) -> ByValue:
    """Return the contribution `rule`, computed by `given` from the point arrays `read` (a NamedTuple), to nodal rows `into`,
    shape (4 nodes,), weighted by N."""
    return ByValue(rule, read, example_of(read), into)


def by_slope(rule: Any, read: Any, into: np.ndarray) -> BySlope:
    """Return the contribution `rule`, computed by `given` from the point arrays `read` (a NamedTuple), to nodal rows `into`,
    shape (4 nodes,), weighted by the gradients of N."""
    return BySlope(rule, read, example_of(read), into)


def giving(mapped: MappedPoints, gives: Any) -> Bundle:
    """Bundle the points of a body with their contribution `gives` to the nodes (`ByValue`, `BySlope`, `BySquare` or `Both`),
    for `scatter`."""
    return Bundle(GivingPoints(Bundle(mapped), gives))


@generic
def given(rule: Any, lattice: Any, points: Any, p: Any) -> Any:
    """Return the values of point p that are multiplied by the shape functions N or their gradients at the nodes; points:
    the input arrays.

    By value: one row of four numbers, or four rows: the value at the point and its derivatives along x, y, z [per m]. By
    gradient: three rows, one for each axis. rule: kind of contribution, whose type selects the implementation.
    """


@generic
def rows_at_nodes(rule: Any, rows: Any, about: Any, cell: float) -> Any:
    """Return the values that are multiplied by N at the nodes of a point: one row of four numbers for each node of its
    stencil `about`, or a single row for all nodes.

    rows: result of `given`; cell: edge of a cell [m]. rule: see `given`.
    """


@generic
def rows_of_line(rule: Any, rows: Any, w: float, dx: float, dy: float) -> Any:
    """Return the values of a point for a line of nodes along z at the distances dx, dy [m] from the point, multiplied by the
    weight w of the line; rows: result of `given`; rule: see `given`."""


@generic
def row_of_node(rule: Any, line: Any, dz: float) -> Any:
    """Return the four numbers that a point contributes to the node at the distance dz [m] along z on a line; line: result of
    `rows_of_line`; rule: see `given`, which defines the four numbers."""


@generic
def scatter_block(gives: Any, mapped: Any, start: Any, n: Any, found: Any, first_node: Any, w: Any, which: Any) -> Any:
    """Add the contributions `gives` of the n points of a block to the nodes.

    mapped: the points (`MappedPoints`); start: number of the first point in the order of the slabs (blocks of grid cells);
    found, first_node: shape functions, see `find_functions`; w: scratch of WEIGHTS columns; which: FIRST, SECOND or their
    sum.
    """


@generic
def add_values(functions: Any, gift: Any, mapped: Any, start: Any, n: Any, found: Any, first_node: Any, w: Any) -> Any:
    """Add a contribution weighted by N (`ByValue`) of the n points of a block to the nodes; functions: shape functions along x,
    y, z; other arguments as in `scatter_block`."""


@generic
def add_slopes(functions: Any, gift: Any, mapped: Any, start: Any, n: Any, found: Any, first_node: Any, w: Any) -> Any:
    """Add a contribution weighted by the gradients of N (`BySlope`) of the n points of a block to the nodes; functions: shape
    functions along x, y, z; other arguments as in `scatter_block`."""


@generic
def add_value_about(folding: Any, lattice: Any, rule: Any, rows: Any, about: Any, into: Any) -> None:
    """Add a contribution weighted by N (`ByValue`) of one point to its nodes.

    folding: that of the lattice; rule, rows: rule of the contribution and result of `given`; about: stencil of the point; into:
    nodal rows.
    """


@generic
def add_slope_about(folding: Any, lattice: Any, slopes: Any, about: Any, into: Any) -> None:
    """Add a contribution weighted by the gradients of N (`BySlope`) of one point to its nodes.

    folding: that of the lattice; slopes: results of `given` for the axes, per cell; about: stencil of the point; into: nodal
    rows.
    """


@point_function(scatter_block, Nothing)
def _give_nothing(gives, mapped, start, n, found, first_node, w, which):
    pass


@point_function(scatter_block, ByValue)
def _give_values(gives, mapped, start, n, found, first_node, w, which):
    if which & FIRST:
        add_values(mapped.functions, gives, mapped, start, n, found, first_node, w)


@point_function(scatter_block, BySlope)
def _give_slopes(gives, mapped, start, n, found, first_node, w, which):
    if which & FIRST:
        add_slopes(mapped.functions, gives, mapped, start, n, found, first_node, w)


@point_function(scatter_block, BySquare)
def _give_squares(gives, mapped, start, n, found, first_node, w, which):
    functions, lattice, into, hh = mapped.functions, mapped.lattice, gives.into, mapped.lattice.inverse_cell**2
    of_across, of_along = gives.factors[0], gives.factors[1]
    for q in range(n):
        about, V = about_point(functions, found, first_node, q), gives.volume[place_of(mapped.index, start + q)]
        wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
        across, along = hh * V * of_across, hh * V * of_along
        sx, sy, sz = row(along, across, across, 0.0), row(across, along, across, 0.0), row(across, across, along, 0.0)
        for a in range(len(wx)):
            for b in range(len(wy)):
                t = (gx[a] * wy[b]) ** 2 * sx + (wx[a] * gy[b]) ** 2 * sy
                u = (wx[a] * wy[b]) ** 2 * sz
                for c in range(len(wz)):
                    I = 4 * node_at(about, lattice, a, b, c)
                    store(into, I, load(into, I) + (wz[c] * wz[c] * t + gz[c] * gz[c] * u))


@point_function(scatter_block, Both)
def _give_both(gives, mapped, start, n, found, first_node, w, which):
    scatter_block(gives.first, mapped, start, n, found, first_node, w, which & FIRST)
    scatter_block(gives.second, mapped, start, n, found, first_node, w, which >> 1)


@default_function(rows_at_nodes)
def _one_for_all(rule, rows, about, cell):
    return rows


@default_function(rows_of_line)
def _share_of_line(rule, rows, w, dx, dy):
    return w * rows


@default_function(row_of_node)
def _as_line(rule, line, dz):
    return line


@pointwise
def _ends_run(first_node, q, n):
    """Return True if point q is the last of the n points of a block, or if the next point has another first node;
    first_node: first nodes of these points."""
    return q + 1 == n or first_node[q + 1] != first_node[q]


@point_function(add_values, LinearFunctions)
def _add_values_of_runs(functions, gift, mapped, start, n, found, first_node, w):
    lattice, rule, into = mapped.lattice, gift.rule, gift.into
    for q in range(n):
        at = about_point(functions, found, first_node, q)
        put(w, q, outer(at.wx, outer(at.wy, at.wz)))
    about = about_point(functions, found, first_node, 0)
    wx, wy, wz = about.wx, about.wy, about.wz
    weights = outer(wx, outer(wy, wz))
    sums = no_sums(weights)
    for q in range(n):
        rows = given(rule, lattice, gift.read, place_of(mapped.index, start + q))
        at_nodes = rows_at_nodes(rule, rows, about_point(functions, found, first_node, q), lattice.cell)
        sums = plus(sums, take(weights, w, q), at_nodes)
        if q % LANES == 0:  # and of the next block the places, which come first
            expect(mapped.index, (ZERO_VECTOR, gift.read_like), (mapped.points.position, gift.read), start + q)
        if _ends_run(first_node, q, n):
            for i in range(len(wx)):
                for j in range(len(wy)):
                    for k in range(len(wz)):
                        I = number_behind(lattice, first_node[q], i, j, k)
                        add_to_row(lattice.folding, into, I, sums[(i * len(wy) + j) * len(wz) + k])
            sums = no_sums(weights)


@point_function(add_slopes, LinearFunctions)
def _add_slopes_of_runs(functions, gift, mapped, start, n, found, first_node, w):
    lattice, into = mapped.lattice, gift.into
    for q in range(n):
        at = about_point(functions, found, first_node, q)
        put(w, q + LINES * WIDTH, (outer(at.wy, at.wz), outer(at.wx, at.wz), outer(at.wx, at.wy)))
    about = about_point(functions, found, first_node, 0)
    wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
    of_x, of_y, of_z = outer(wy, wz), outer(wx, wz), outer(wx, wy)
    x, y, z = no_sums(of_x), no_sums(of_y), no_sums(of_z)
    for q in range(n):
        sx, sy, sz = given(gift.rule, lattice, gift.read, place_of(mapped.index, start + q))
        along_x, along_y, along_z = take((of_x, of_y, of_z), w, q + LINES * WIDTH)
        x, y, z = plus(x, along_x, sx), plus(y, along_y, sy), plus(z, along_z, sz)
        if q % LANES == 0:
            expect(mapped.index, gift.read_like, gift.read, start + q)
        if _ends_run(first_node, q, n):
            for i in range(len(wx)):
                for j in range(len(wy)):
                    for k in range(len(wz)):
                        I = number_behind(lattice, first_node[q], i, j, k)
                        along = gx[i] * x[j * len(wz) + k] + gy[j] * y[i * len(wz) + k] + gz[k] * z[i * len(wy) + j]
                        add_to_row(lattice.folding, into, I, lattice.inverse_cell * along)
            x, y, z = no_sums(of_x), no_sums(of_y), no_sums(of_z)


@pointwise
def _add_value(lattice, rule, rows, about, into):
    wx, wy, wz, offset, h = about.wx, about.wy, about.wz, about.offset, lattice.cell
    for a in range(len(wx)):
        for b in range(len(wy)):
            line = rows_of_line(rule, rows, wx[a] * wy[b], (offset[0] + a) * h, (offset[1] + b) * h)
            for c in range(len(wz)):
                I = number_at(about, lattice, a, b, c)
                add_to_row(lattice.folding, into, I, wz[c] * row_of_node(rule, line, (offset[2] + c) * h))


@default_function(add_value_about)
def _add_value_within(folding, lattice, rule, rows, about, into):
    _add_value(lattice, rule, rows, about, into)


@point_function(add_value_about, Mirrored)
def _add_value_beside_plane(folding, lattice, rule, rows, about, into):
    if folding.reaches[uintp(about.start + folding.shift)]:
        _add_value(lattice, rule, rows, about, into)
    else:
        _add_value(without_images(lattice), rule, rows, about, into)


@pointwise
def _add_slope(lattice, slopes, about, into):
    wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
    sx, sy, sz = slopes
    for a in range(len(wx)):
        for b in range(len(wy)):
            t = (gx[a] * wy[b]) * sx + (wx[a] * gy[b]) * sy
            u = (wx[a] * wy[b]) * sz
            for c in range(len(wz)):
                I = number_at(about, lattice, a, b, c)
                add_to_row(lattice.folding, into, I, wz[c] * t + gz[c] * u)


@default_function(add_slope_about)
def _add_slope_within(folding, lattice, slopes, about, into):
    _add_slope(lattice, slopes, about, into)


@point_function(add_slope_about, Mirrored)
def _add_slope_beside_plane(folding, lattice, slopes, about, into):
    if folding.reaches[uintp(about.start + folding.shift)]:
        _add_slope(lattice, slopes, about, into)
    else:
        _add_slope(without_images(lattice), slopes, about, into)


@point_function(add_values, CurvedFunctions)
def _add_values_of_points(functions, gift, mapped, start, n, found, first_node, w):
    lattice, rule, into = mapped.lattice, gift.rule, gift.into
    for q in range(n):
        about = about_point(functions, found, first_node, q)
        rows = given(rule, lattice, gift.read, place_of(mapped.index, start + q))
        add_value_about(lattice.folding, lattice, rule, rows, about, into)


@point_function(add_slopes, CurvedFunctions)
def _add_slopes_of_points(functions, gift, mapped, start, n, found, first_node, w):
    lattice, into, h = mapped.lattice, gift.into, mapped.lattice.inverse_cell
    for q in range(n):
        about = about_point(functions, found, first_node, q)
        sx, sy, sz = given(gift.rule, lattice, gift.read, place_of(mapped.index, start + q))
        add_slope_about(lattice.folding, lattice, (h * sx, h * sy, h * sz), about, into)


@generic
def scatter_where(
    folding: Any, gives: Any, mapped: Any, start: Any, n: Any, found: Any, first_node: Any, w: Any, which: Any
) -> None:
    """Add contributions of the n points of a block as `scatter_block`, with nodes beyond planes of symmetry only if the block
    reaches them; folding: that of the lattice of `mapped`."""


@default_function(scatter_where)
def _scatter_within(folding, gives, mapped, start, n, found, first_node, w, which):
    scatter_block(gives, mapped, start, n, found, first_node, w, which)


@point_function(scatter_where, Mirrored)
def _scatter_beside_planes(folding, gives, mapped, start, n, found, first_node, w, which):
    if reaches_images(folding, first_node, n):
        scatter_block(gives, mapped, start, n, found, first_node, w, which)
    else:
        m = mapped
        within = MappedPoints(m.functions, without_images(m.lattice), m.nodes, m.points, m.slabs, m.index)
        scatter_block(gives, within, start, n, found, first_node, w, which)


def arrays_given(gives: Any, which: int = FIRST) -> list[np.ndarray]:
    """Return the nodal arrays to which the contributions `gives` are added; which: FIRST, SECOND of two contributions, or their
    sum."""
    if isinstance(gives, Both):
        return arrays_given(gives.first, which & FIRST) + arrays_given(gives.second, which >> 1)
    return [gives.into] if which & FIRST and hasattr(gives, "into") else []


@kernel(inner=True)
def add_block(points, start, n, found, first_node, w, which):
    """Add the contributions of n points of a block, bundled by `giving`; the other arguments are those of `scatter_block`."""
    mapped = points.mapped
    scatter_where(mapped.lattice.folding, points.gives, mapped, start, n, found, first_node, w, which)


@kernel(inner=True)
def _slab(s, points, which):
    mapped = points.mapped
    functions, lattice, slabs, index = mapped.functions, mapped.lattice, mapped.slabs, mapped.index
    if slabs.first[s] == slabs.first[s + 1]:
        return
    found, first_node, c = numbers(WIDTH * size(functions_like(functions))), indices(BLOCK), numbers(WIDTH * size(ZERO_VECTOR))
    weights = numbers(WIDTH * WEIGHTS)
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch(index, ZERO_VECTOR, mapped.points.position, start, n, c, 0)
        find_functions(functions, lattice, n, c, 0, found, first_node)
        call_kernel(add_block, points, start, n, found, first_node, weights, which)


@kernel()
def _scatter(n, points, which):
    joint_by_colour(_slab, n, points.mapped.slabs.across, points, which)


def scatter(points: Bundle, which: int = FIRST) -> None:
    """Add the contributions of the points of a body, bundled by `giving`, to the nodes; which: FIRST, SECOND of two
    contributions, or their sum."""
    n = len(points.mapped.slabs.layers)
    joint_region.give(lambda: _scatter(n, points, which), lambda: arrays_given(points.gives, which))
