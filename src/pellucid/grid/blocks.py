"""Blocks of points: where their shape functions are found once, in columns, for vectors of points and for each point.

Points of a block that follow each other in one cell form a run; their nodes are the same, so that sums over the nodes go by
vectors of `LANES` points. A vector may reach beyond its run: what it finds for the points there is overwritten by theirs.
"""

from numpy import uintp

from pellucid.approximants.axis import axis_numbers, axis_values
from pellucid.grid.points import place_of
from pellucid.grid.stencil import Stencil
from pellucid.jit import pointwise
from pellucid.jit.columns import WIDTH, put, take, take_lanes
from pellucid.jit.vector import LANES, larger, load, store


@pointwise
def functions_like(functions):
    """What the columns of shape functions hold of a point, along each axis."""
    _, x = axis_numbers(functions[0], 0.0, 1)
    _, y = axis_numbers(functions[1], 0.0, 1)
    _, z = axis_numbers(functions[2], 0.0, 1)
    return x, y, z


@pointwise
def find_functions(functions, lattice, index, position, start, n, found, first_node):
    """Shape functions of the n points that slabs count from `start` on, into columns of `found`, and their first nodes."""
    h, low, counts, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for q in range(n):
        p = place_of(index, start + q)
        i, x = axis_numbers(functions[0], (position[p, 0] - low[0]) * h, counts[0])
        j, y = axis_numbers(functions[1], (position[p, 1] - low[1]) * h, counts[1])
        k, z = axis_numbers(functions[2], (position[p, 2] - low[2]) * h, counts[2])
        first_node[q] = int(i * stride[0] + j * stride[1] + k * stride[2])
        put(found, q, (x, y, z))


@pointwise
def _stencil(functions, node, numbers):
    ox, wx, gx = axis_values(functions[0], numbers[0])
    oy, wy, gy = axis_values(functions[1], numbers[1])
    oz, wz, gz = axis_values(functions[2], numbers[2])
    return Stencil(node, (ox, oy, oz), wx, wy, wz, gx, gy, gz)


@pointwise
def about_point(functions, found, first_node, q):
    """The stencil of point q of a block."""
    return _stencil(functions, first_node[q], take(functions_like(functions), found, q))


@pointwise
def about_lanes(functions, found, first_node, q):
    """The stencil of the points from q on that share their nodes with it."""
    return _stencil(functions, first_node[q], take_lanes(functions_like(functions), found, q))


@pointwise
def run_end(first_node, q, n):
    """The end of the run that begins at point q of n points."""
    node, end = first_node[q], q + 1
    while end < n and first_node[end] == node:
        end += 1
    return end


@pointwise
def add_columns(c, column, n, sums, number, count):
    """Add the n numbers of each of `count` columns, from `column` on, to as many vectors of sums, from `number` on."""
    for k in range(count):
        at = (column + k) * WIDTH
        for q in range(n, (n + LANES - 1) // LANES * LANES):
            c[uintp(at + q)] = 0.0
        total = load(sums, (number + k) * LANES)
        for q in range(0, n, LANES):
            total += load(c, at + q)
        store(sums, (number + k) * LANES, total)


@pointwise
def largest_of_column(c, column, n, sums, number):
    """Let each lane of a vector of sums be the largest of what it was and the n numbers of a column."""
    at = column * WIDTH
    for q in range(n, (n + LANES - 1) // LANES * LANES):
        c[uintp(at + q)] = 0.0
    top = load(sums, number * LANES)
    for q in range(0, n, LANES):
        top = larger(load(c, at + q), top)
    store(sums, number * LANES, top)
