"""Blocks of points. For each block, shape functions are computed once, in columns, for vectors of points and for single
points.

Consecutive points of a block in the same cell form a run. They share their nodes, so sums over the nodes are computed for
vectors of `LANES` points. A vector may extend beyond its run; the results for the points beyond are overwritten when their
own run is processed.
"""

from typing import Any

import numpy as np
from numpy import uintp

from pellucid.approximants.grid_functions import axis_numbers
from pellucid.grid.points import ByIndex, InOrder, place_of
from pellucid.grid.stencil import functions_at, stencil_of
from pellucid.jit import generic, kernel, point_function, pointwise
from pellucid.jit.columns import BLOCK, WIDTH, put, take, take_lanes
from pellucid.jit.registry import LINE
from pellucid.jit.rows import expect_rows, keep_row, keep_rows, prefetch, take_row, take_rows
from pellucid.jit.vector import LANES, larger, load, store
from pellucid.tensors import ZERO_VECTOR


@generic
def fetch(index: Any, like: Any, arrays: Any, start: int, n: int, c: Any, at: int) -> None:
    """Copy values of n points of a block from their arrays to columns, i.e. scratch memory with one column per number of a
    point, see `pellucid.jit.columns`.

    index: order of the points in the arrays, `InOrder` or `ByIndex`; like: example of the values of one point, nested
    tuples of numbers; arrays: the arrays, nested like `like`; start: number of the first point of the block in the order of
    the slabs (blocks of grid cells); c: columns; at: position in c for the first number of the first point.
    """


@generic
def keep(index: Any, like: Any, arrays: Any, start: int, n: int, c: Any, at: int) -> None:
    """Copy values of n points of a block from columns back to their arrays: the inverse of `fetch`, whose docstring
    explains the arguments."""


@generic
def expect(index: Any, like: Any, arrays: Any, q: int) -> None:
    """Load the values of LANES points into the processor cache: of the points that follow one block after number q in the
    order of the slabs; index, like, arrays: see `fetch`.

    Called for each vector of a block, so that the rows of the next block arrive while the present block is processed.
    Prefetching a whole block at once would stall the processor as long as reading the block.
    """


@pointwise
def prefetch_next(lines, q):
    """Load the values of LANES points one block after number q into the processor cache, as `expect` does; lines: result of
    `cache_lines`."""
    for k in range(len(lines)):
        prefetch(lines[k, 0] + (q + BLOCK) * lines[k, 1])


def cache_lines(arrays: list[np.ndarray]) -> np.ndarray:
    """Return the cache lines that the rows of LANES consecutive points occupy in these arrays, shape (lines, 2): address of the
    line for the first points, and size of a row, both in bytes."""
    rows = [(array.ctypes.data, array.strides[0]) for array in arrays]
    lines = [(address + line, size) for address, size in rows for line in range(0, LANES * size, LINE)]
    return np.array(lines, np.int64).reshape(-1, 2)  # the last line may lie beyond the array: that is no fault


@point_function(fetch, InOrder)
def _fetch_in_order(index, like, arrays, start, n, c, at):
    whole = n // LANES * LANES
    for q in range(0, whole, LANES):
        put(c, at + q, take_rows(like, arrays, uintp(start + q)))
    for q in range(whole, n):
        put(c, at + q, take_row(like, arrays, uintp(start + q)))


@point_function(keep, InOrder)
def _keep_in_order(index, like, arrays, start, n, c, at):
    whole = n // LANES * LANES
    for q in range(0, whole, LANES):
        keep_rows(arrays, uintp(start + q), take_lanes(like, c, at + q))
    for q in range(whole, n):
        keep_row(arrays, uintp(start + q), take(like, c, at + q))


@point_function(expect, InOrder)
def _expect_in_order(index, like, arrays, q):
    expect_rows(like, arrays, uintp(q + BLOCK))


@point_function(expect, ByIndex)
def _expect_nothing(index, like, arrays, q):
    pass


@point_function(fetch, ByIndex)
def _fetch_by_index(index, like, arrays, start, n, c, at):
    for q in range(n):
        put(c, at + q, take_row(like, arrays, place_of(index, start + q)))


@point_function(keep, ByIndex)
def _keep_by_index(index, like, arrays, start, n, c, at):
    for q in range(n):
        keep_row(arrays, place_of(index, start + q), take(like, c, at + q))


@kernel(inner=True)
def fetch_block(rows, start, n, c, at):
    """Copy values of n points of a block from the arrays of `rows` (`PointRows`) to columns; start, n, c, at: as in
    `fetch`."""
    fetch(rows.index, rows.like, rows.arrays, start, n, c, at)


@pointwise
def keep_where(flags, all_set, index, like, arrays, start, n, c, at):
    """Copy values from columns back to the arrays for those points of a block whose number in the column `flags` is
    positive.

    all_set: True if all n numbers are known to be positive; index, like, arrays, start, n, c, at: see `fetch`.
    """
    if all_set:
        keep(index, like, arrays, start, n, c, at)
        return
    for q in range(n):
        if c[uintp(q + flags * WIDTH)] > 0.0:
            keep_row(arrays, place_of(index, start + q), take(like, c, q + at))


@kernel(inner=True)
def keep_block(rows, flags, all_set, start, n, c, at):
    """Copy values of n points of a block from columns back to the arrays of `rows` (`PointRows`), for those points whose
    number in the column `flags` is positive; arguments: see `keep_where`."""
    keep_where(flags, all_set, rows.index, rows.like, rows.arrays, start, n, c, at)


@pointwise
def functions_like(functions):
    """Return an example of the numbers that define the shape functions of a point along x, y, z, see `axis_numbers`; the
    example determines the layout of the columns for these numbers."""
    _, x = axis_numbers(functions[0], 0.0, 1)
    _, y = axis_numbers(functions[1], 0.0, 1)
    _, z = axis_numbers(functions[2], 0.0, 1)
    return x, y, z


@pointwise
def find_functions(functions, lattice, n, c, at, found, first_node):
    """Compute the numbers that define the shape functions of n points (`axis_numbers`), into the columns `found`, and the
    storage indices of their first nodes, into `first_node`.

    functions: shape functions along x, y, z; c: columns with the positions of the points [m], from `at` on.
    """
    for q in range(n):
        first_node[q], numbers = functions_at(functions, lattice, take(ZERO_VECTOR, c, at + q))
        put(found, q, numbers)


@pointwise
def about_point(functions, found, first_node, q):
    """Return the stencil of point q of a block; other arguments as in `find_functions`."""
    return stencil_of(functions, first_node[q], take(functions_like(functions), found, q))


@pointwise
def about_lanes(functions, found, first_node, q):
    """Return the common stencil, with vectors of LANES shape functions, of the points from q on that share their nodes with
    point q; other arguments as in `find_functions`."""
    return stencil_of(functions, first_node[q], take_lanes(functions_like(functions), found, q))


@pointwise
def run_end(first_node, q, n):
    """Return the end of the run (consecutive points with the same first node) that begins at point q of the n points of a
    block; first_node: first nodes of these points."""
    node, end = first_node[q], q + 1
    while end < n and first_node[end] == node:
        end += 1
    return end


@pointwise
def add_columns(c, column, n, sums, number, count):
    """Add the n numbers of each of `count` columns of c, from number `column` on, lane by lane to `count` vectors of `sums`,
    from vector `number` on."""
    for k in range(column, column + count):
        for q in range(n, (n + LANES - 1) // LANES * LANES):
            c[uintp(q + k * WIDTH)] = 0.0
    whole = count // 4 * 4
    for k in range(0, whole, 4):  # four sums at a time: each addition waits for the one before it
        at, to = (column + k) * WIDTH, (number + k) * LANES
        x, y = load(sums, to), load(sums, to + LANES)
        z, w = load(sums, to + 2 * LANES), load(sums, to + 3 * LANES)
        for q in range(at, at + n, LANES):
            x, y = x + load(c, q), y + load(c, q + WIDTH)
            z, w = z + load(c, q + 2 * WIDTH), w + load(c, q + 3 * WIDTH)
        store(sums, to, x)
        store(sums, to + LANES, y)
        store(sums, to + 2 * LANES, z)
        store(sums, to + 3 * LANES, w)
    for k in range(whole, count):
        total = load(sums, (number + k) * LANES)
        for q in range((column + k) * WIDTH, (column + k) * WIDTH + n, LANES):
            total = total + load(c, q)
        store(sums, (number + k) * LANES, total)


@pointwise
def largest_of_column(c, column, n, sums, number):
    """Update maxima over points: replace each lane of vector `number` of `sums` by the larger of its value and the numbers
    of this lane in a column of c. n: number of points, each with a number in the column."""
    at = column * WIDTH
    for q in range(n, (n + LANES - 1) // LANES * LANES):
        c[uintp(at + q)] = 0.0
    top = load(sums, number * LANES)
    for q in range(0, n, LANES):
        top = larger(load(c, at + q), top)
    store(sums, number * LANES, top)
