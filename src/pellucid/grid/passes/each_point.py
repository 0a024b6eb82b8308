"""The loop that executes a pass over the points of a body on a CPU.

Only this module handles slabs, blocks, columns, vectors and prefetching; a pass handles one point (`points_pass`). Three
rules make the loop fast. Gathering processes several points that share their nodes at a time. The loop over the physics of
a point writes only to columns, so that the compiler vectorizes it. Each part prefetches memory of the next block. A line
that breaks a rule makes a pass slower by a quarter: `pellucid bench` measures each pass, and `benchmarks/pairs.py` compares
two states of the source.
"""

from typing import Any

from numpy import intp, uintp

from pellucid.grid.passes.blocks import (
    about_lanes,
    about_point,
    add_columns,
    expect,
    fetch,
    find_functions,
    functions_like,
    keep_where,
    largest_of_column,
    run_end,
)
from pellucid.grid.passes.gifts import WEIGHTS, arrays_given, scatter_block
from pellucid.grid.passes.places import bounds_of, comes_first, fault_of_place, in_cells, outside, strays
from pellucid.grid.passes.points_pass import NotToCells, ToCells, at_point, gathered, in_cell, looked_up
from pellucid.grid.points import INVERTED, LOST, OK, VECTORS, cell_at, place_of
from pellucid.jit import generic, kernel, point_function, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.columns import BLOCK, WIDTH, put, put_like, size, take, take_lanes
from pellucid.jit.joint import joint_region
from pellucid.jit.local import indices, numbers, zeros
from pellucid.jit.parallel import joint_by_colour, joint_for
from pellucid.jit.vector import LANES, load, total
from pellucid.tensors import ZERO_VECTOR

NO_PLACE = 1e3
"""Fault value that marks a point whose new position is outside the grid or not finite."""


@pointwise
def _look_up(points, n, found, first_node, c):
    """Look up values for the n points of a block before gathering, into columns after the input."""
    functions, lattice = points.mapped.functions, points.mapped.lattice
    for q in range(n):
        about, p = about_point(functions, found, first_node, q), take(points.read_like, c, q)
        known = looked_up(points.task, lattice, functions, about, p)
        put_like(points.known_like, c, q + size(points.read_like) * WIDTH, known)


@pointwise
def _gather(points, start, n, found, first_node, c):
    """Gather nodal values into columns after the looked-up values; return the number of vectors of points."""
    functions, lattice, nodes, index = points.mapped.functions, points.mapped.lattice, points.mapped.nodes, points.mapped.index
    like, known_like = points.read_like, points.known_like
    a = vectors = 0
    while a < n:
        end = run_end(first_node, a, n)
        vectors += (end - a + LANES - 1) // LANES
        while a < end:
            expect(index, like, points.read, start + a)
            about, p = about_lanes(functions, found, first_node, a), take_lanes(like, c, a)
            known = take_lanes(known_like, c, a + size(like) * WIDTH)
            gathers = gathered(points.task, about, lattice, nodes, p, known)
            put_like(points.gathered_like, c, a + (size(like) + size(known_like)) * WIDTH, gathers)
            a += LANES
        a = end
    return vectors


@pointwise
def _find(points, dt, n, c):
    """Evaluate the pass at each point and overwrite the columns of looked-up and gathered values, which stay in the cache."""
    like, known_like, gathered_like = points.read_like, points.known_like, points.gathered_like
    GATHERED, task, lattice = size(like) + size(known_like), points.task, points.mapped.lattice
    for q in range(n):
        p, known = take(like, c, q), take(known_like, c, q + size(like) * WIDTH)
        g = take(gathered_like, c, q + GATHERED * WIDTH)
        found = at_point(task, lattice, dt, p, known, g)
        put_like(points.found_like, c, q + size(like) * WIDTH, found)


@pointwise
def _check_places(lattice, bounds, n, c, at, fault):
    """Check the new positions in columns from `at` on. Writes the fault of each point that has no other fault, and to the
    next column 1.0 if the point is outside the bounds of its slab."""
    for q in range(n):
        X, Y, Z = in_cells(lattice, take(ZERO_VECTOR, c, q + at))
        bad = c[uintp(q + fault)]
        bad = bad if bad > 0.0 else NO_PLACE * outside(lattice, X, Y, Z)
        put(c, q + fault, (bad, strays(lattice, X, Y, Z, bounds)))


@pointwise
def _code(c, q, at, fault):
    """Return the fault of point q of a block."""
    code = c[uintp(q + fault)]
    return fault_of_place(take(ZERO_VECTOR, c, q + at)) if code == NO_PLACE else int(code)


@generic
def add_to_cells(to_cells: Any, points: Any, n: int, c: Any) -> None:
    """Add the contributions of the n points of a block to their cells."""


@point_function(add_to_cells, NotToCells)
def _add_nothing(to_cells, points, n, c):
    pass


@point_function(add_to_cells, ToCells)
def _add_numbers(to_cells, points, n, c):
    like, GATHERED = points.read_like, size(points.read_like) + size(points.known_like)
    for q in range(n):
        p, g = take(like, c, q), take(points.gathered_like, c, q + GATHERED * WIDTH)
        to_cells.into[cell_at(points.mapped.lattice, p.position), to_cells.column] += in_cell(points.task, p, g)


@kernel(inner=True)
def _slab(s, points, dt, which):
    mapped = points.mapped
    functions, lattice, index, slabs = mapped.functions, mapped.lattice, mapped.index, mapped.slabs
    if slabs.first[s] == slabs.first[s + 1]:
        return
    like, kept_like = points.read_like, points.found_like.kept
    columns, bounds = size(points.found_like.sums), bounds_of(slabs, s)
    KEPT, GATHERED = size(like), size(points.known_like) + size(points.gathered_like)
    SUMS = KEPT + size(kept_like)
    LARGEST = SUMS + columns
    FAULT, BEYOND, COLUMNS = LARGEST + 1, LARGEST + 2, max(LARGEST + 3, KEPT + GATHERED)
    # sums of the pass; the largest; faults; points beyond their slab; sums of the points that left the grid
    c, sums, of_lost = numbers(WIDTH * COLUMNS), zeros((columns + 3) * LANES), zeros(columns)
    found, first_node, weights = numbers(WIDTH * size(functions_like(functions))), indices(BLOCK), numbers(WIDTH * WEIGHTS)
    first_fault = at_fault = vectors = 0
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch(index, like, points.read, start, n, c, 0)
        find_functions(functions, lattice, n, c, 0, found, first_node)
        if size(points.known_like) > 0:
            _look_up(points, n, found, first_node, c)
        vectors += _gather(points, start, n, found, first_node, c)
        add_to_cells(points.to_cells, points, n, c)
        _find(points, dt, n, c)
        if points.places:
            _check_places(lattice, bounds, n, c, KEPT * WIDTH, FAULT * WIDTH)
            add_columns(c, BEYOND, n, sums, columns + 2, 1)
        add_columns(c, SUMS, n, sums, 0, columns)
        add_columns(c, FAULT, n, sums, columns + 1, 1)
        if points.largest >= 0:
            largest_of_column(c, LARGEST, n, sums, columns)
        sound = total(load(sums, (columns + 1) * LANES)) == 0.0
        if not sound:
            for q in range(n):
                fault = OK if c[uintp(q + FAULT * WIDTH)] == 0.0 else _code(c, q, KEPT * WIDTH, FAULT * WIDTH)
                if fault == LOST:
                    for k in range(columns):
                        of_lost[k] += c[uintp(q + (SUMS + k) * WIDTH)]
                if comes_first(fault, first_fault):
                    first_fault = fault
                    at_fault = intp(place_of(index, start + q))  # type: ignore[assignment]
                c[uintp(q + FAULT * WIDTH)] = 0.0 if fault == INVERTED else 1.0
        keep_where(FAULT, sound, index, kept_like, points.kept, start, n, c, KEPT * WIDTH)
        scatter_block(points.gives, mapped, start, n, found, first_node, weights, which)
    slabs.sums[s, VECTORS] = vectors
    for k in range(columns):
        slabs.sums[s, points.sums[k]] = total(load(sums, k * LANES))
    if points.largest >= 0:
        top = 0.0
        for lane in range(LANES):
            top = max(top, sums[columns * LANES + lane])
        slabs.sums[s, points.largest] = top
    if points.places:
        slabs.left_slab[s] = 1 if total(load(sums, (columns + 2) * LANES)) > 0.0 else 0
        for k in range(columns):
            slabs.of_lost[s, points.sums[k]] = of_lost[k]
    if points.places or comes_first(first_fault, slabs.fault[s, 0]):  # new places begin a new report
        slabs.fault[s, 0] = first_fault
        slabs.fault[s, 1] = at_fault


@kernel()
def _each_point(n, points, dt):
    joint_for(_slab, n, points, dt, 0)


@kernel()
def _each_point_by_colour(n, points, dt, which):
    joint_by_colour(_slab, n, points.mapped.slabs.across, points, dt, which)


def each_point(points: Bundle, dt: float, which: int = 0) -> None:
    """Execute a pass (`pass_points`) on the points of a body, over a step dt [s].

    which: its contributions to the nodes, `gifts.FIRST`, `SECOND`, their sum, or 0 for none. Fills the declared sums,
    VECTORS and faults, and, for a pass that moves points, `left_slab` and `of_lost`.
    """
    n = len(points.mapped.slabs.layers)
    if points.by_colour:  # always, so that in a joint region it is one kind of loop, before or after others of the body
        joint_region.give(
            lambda: _each_point_by_colour(n, points, dt, which),
            lambda: arrays_given(points.gives, which) + arrays_given(points.to_cells),
        )
    else:
        _each_point(n, points, dt)
