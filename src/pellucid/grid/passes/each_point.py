"""The loop that executes a pass over the points of a body on a CPU.

Only this module handles slabs, blocks, columns, vectors and prefetching; a pass handles one point (`points_pass`). The parts
of the loop are kernels that are called for each block and shared: gathering by all laws, the evaluation of a law by all shape
functions, sums and faults by all passes. A new law or case therefore compiles little.

Four rules make the loop fast. Gathering processes several points that share their nodes at a time. The loop over the physics
of a point writes only to columns, so that the compiler vectorizes it. Each part prefetches memory of the next block. Scratch
memory begins with zeros: lanes beyond the last point of a block do not count, but processors are slow with the denormal
numbers that a stack may hold. A line that breaks a rule makes a pass slower by a quarter or more: `pellucid bench` measures
each pass, and `benchmarks/pairs.py` compares two states of the source.
"""

from typing import Any

from numpy import intp, uintp

from pellucid.grid.folding import Mirrored, reaches_images
from pellucid.grid.lattice import without_images
from pellucid.grid.passes.blocks import (
    about_lanes,
    about_point,
    add_columns,
    fetch_block,
    find_functions,
    functions_like,
    keep_block,
    largest_of_column,
    prefetch_next,
    run_end,
)
from pellucid.grid.passes.gifts import WEIGHTS, add_block, arrays_given
from pellucid.grid.passes.places import bounds_of, comes_first, fault_of_place, in_cells, outside, strays
from pellucid.grid.passes.points_pass import NotToCells, ToCells, at_point, gathered_about, in_cell, looked_up
from pellucid.grid.points import INVERTED, LOST, OK, VECTORS, cell_at, place_of
from pellucid.jit import default_function, generic, kernel, point_function, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.calls import call_kernel
from pellucid.jit.columns import BLOCK, WIDTH, put, put_like, size, take, take_lanes
from pellucid.jit.loops import joint_by_colour, joint_for, joint_region
from pellucid.jit.memory import indices, numbers, zeros
from pellucid.jit.vector import LANES, load, total
from pellucid.tensors import ZERO_VECTOR

NO_PLACE = 1e3
"""Fault value that marks a point whose new position is outside the grid or not finite."""


@kernel(inner=True)
def _gather(points, start, n, KNOWN, found, first_node, c):
    """Compute the shape functions of the n points of a block, and their looked-up and gathered values, into columns of c
    from the column KNOWN on; return the number of vectors of points that were processed.

    points: bundled `Gathering`; start: number of the first point in the order of the slabs (blocks of grid cells); found,
    first_node: shape functions, see `find_functions`.
    """
    rule, functions, lattice = points.rule, points.functions, points.lattice
    like, known_like = points.read_like, points.known_like
    find_functions(functions, lattice, n, c, 0, found, first_node)
    if size(known_like) > 0:
        for q in range(n):
            about, p = about_point(functions, found, first_node, q), take(like, c, q)
            put_like(known_like, c, q + KNOWN * WIDTH, looked_up(rule, lattice, functions, about, p))
    return gather_block(lattice.folding, lattice, points, start, n, KNOWN, found, first_node, c)


@generic
def gather_block(
    folding: Any, lattice: Any, points: Any, start: Any, n: Any, KNOWN: Any, found: Any, first_node: Any, c: Any
) -> Any:
    """Compute the gathered values of the n points of a block; return the number of vectors of points. folding, lattice: of the
    points, with nodes beyond planes of symmetry only in blocks that reach them; other arguments as in `_gather`."""


@pointwise
def _gather_runs(lattice, points, start, n, KNOWN, found, first_node, c):
    rule, functions, nodes = points.rule, points.functions, points.nodes
    like, known_like, gathered_like, lines = points.read_like, points.known_like, points.gathered_like, points.lines
    a = vectors = 0
    while a < n:
        end = run_end(first_node, a, n)
        vectors += (end - a + LANES - 1) // LANES
        while a < end:
            prefetch_next(lines, start + a)
            about, p = about_lanes(functions, found, first_node, a), take_lanes(like, c, a)
            known = take_lanes(known_like, c, a + KNOWN * WIDTH)
            gathers = gathered_about(lattice.folding, rule, about, lattice, nodes, p, known)
            put_like(gathered_like, c, a + (KNOWN + size(known_like)) * WIDTH, gathers)
            a += LANES
        a = end
    return vectors


@default_function(gather_block)
def _gather_within(folding, lattice, points, start, n, KNOWN, found, first_node, c):
    return _gather_runs(lattice, points, start, n, KNOWN, found, first_node, c)


@point_function(gather_block, Mirrored)
def _gather_beside_planes(folding, lattice, points, start, n, KNOWN, found, first_node, c):
    if reaches_images(folding, first_node, n):
        return _gather_runs(lattice, points, start, n, KNOWN, found, first_node, c)
    return _gather_runs(without_images(lattice), points, start, n, KNOWN, found, first_node, c)


@kernel(inner=True)
def _evaluate(points, dt, n, c):
    """Evaluate the pass at the n points of a block over a step dt [s]. The results overwrite the columns of looked-up and
    gathered values in c, which stay in the cache. points: bundled `Evaluation`."""
    task, lattice, found_like = points.task, points.lattice, points.found_like
    like, known_like, gathered_like = points.read_like, points.known_like, points.gathered_like
    KNOWN = size(like)
    GATHERED = KNOWN + size(known_like)
    for q in range(n):
        p, known = take(like, c, q), take(known_like, c, q + KNOWN * WIDTH)
        g = take(gathered_like, c, q + GATHERED * WIDTH)
        put_like(found_like, c, q + KNOWN * WIDTH, at_point(task, lattice, dt, p, known, g))


@pointwise
def _check_places(lattice, bounds, n, c, at, fault):
    """Check the new positions of the n points of a block, in columns of c from `at` on. Writes the fault of each point that
    has no other fault to the column that begins at `fault`, and 1.0 to the next column if the point is outside the bounds
    of its slab, a block of grid cells (`bounds`, see `bounds_of`)."""
    for q in range(n):
        X, Y, Z = in_cells(lattice, take(ZERO_VECTOR, c, q + at))
        bad = c[uintp(q + fault)]
        bad = bad if bad > 0.0 else NO_PLACE * outside(lattice, X, Y, Z)
        put(c, q + fault, (bad, strays(lattice, X, Y, Z, bounds)))


@pointwise
def _code(c, q, at, fault):
    """Return the fault code of point q of a block; other arguments as in `_check_places`."""
    code = c[uintp(q + fault)]
    return fault_of_place(take(ZERO_VECTOR, c, q + at)) if code == NO_PLACE else int(code)


@generic
def add_to_cells(to_cells: Any, points: Any, n: int, c: Any) -> None:
    """Add the numbers of the n points of a block to the sums of their grid cells, if `to_cells` is `ToCells`. points: bundled
    `Evaluation`; c: columns."""


@point_function(add_to_cells, NotToCells)
def _add_nothing(to_cells, points, n, c):
    pass


@point_function(add_to_cells, ToCells)
def _add_numbers(to_cells, points, n, c):
    task, lattice, like, gathered_like = points.task, points.lattice, points.read_like, points.gathered_like
    GATHERED = size(like) + size(points.known_like)
    for q in range(n):
        p, g = take(like, c, q), take(gathered_like, c, q + GATHERED * WIDTH)
        to_cells.into[cell_at(lattice, p.position), to_cells.column] += in_cell(task, p, g)


@kernel(inner=True)
def _account(points, places, largest, columns, KEPT, SUMS, bounds, start, n, c, sums, of_lost, first_fault):
    """Check the results of the n points of a block and add them to the sums of the slab (a block of grid cells); return
    True if no point has a fault.

    points: bundled `Accounting`; places: see `Declaration`; largest: True if there is a maximum; KEPT: first column of c
    with output; columns: number of sums of the pass, in columns from SUMS on; bounds: see `bounds_of`; start: number of the
    first point. sums: vectors of the sums of the pass, the maximum, the faults, and the number of points outside the slab;
    of_lost: sums of the points that left the grid; first_fault: fault to report, and its point.
    """
    LARGEST = SUMS + columns
    FAULT, BEYOND = LARGEST + 1, LARGEST + 2
    if places:
        _check_places(points.lattice, bounds, n, c, KEPT * WIDTH, FAULT * WIDTH)
        add_columns(c, BEYOND, n, sums, columns + 2, 1)
    add_columns(c, SUMS, n, sums, 0, columns)
    add_columns(c, FAULT, n, sums, columns + 1, 1)
    if largest:
        largest_of_column(c, LARGEST, n, sums, columns)
    if total(load(sums, (columns + 1) * LANES)) == 0.0:
        return True
    for q in range(n):
        fault = OK if c[uintp(q + FAULT * WIDTH)] == 0.0 else _code(c, q, KEPT * WIDTH, FAULT * WIDTH)
        if fault == LOST:
            for k in range(columns):
                of_lost[k] += c[uintp(q + (SUMS + k) * WIDTH)]
        if comes_first(fault, first_fault[0]):
            first_fault[0] = fault
            first_fault[1] = intp(place_of(points.index, start + q))
        c[uintp(q + FAULT * WIDTH)] = 0.0 if fault == INVERTED else 1.0
    return False


@kernel(inner=True)
def _report(s, slabs, places, of_pass, columns, largest, sums, of_lost, first_fault, vectors):
    """Write the sums and the fault of slab s to `slabs` (`Slabs`).

    of_pass, largest: columns of `Slabs.sums` for the sums and the maximum (negative: none); vectors: number of vectors
    processed; other arguments as in `_account`.
    """
    slabs.sums[s, VECTORS] = vectors
    for k in range(columns):
        slabs.sums[s, of_pass[k]] = total(load(sums, k * LANES))
    if largest >= 0:
        top = 0.0
        for lane in range(LANES):
            top = max(top, sums[columns * LANES + lane])
        slabs.sums[s, largest] = top
    if places:
        slabs.left_slab[s] = 1 if total(load(sums, (columns + 2) * LANES)) > 0.0 else 0
        for k in range(columns):
            slabs.of_lost[s, of_pass[k]] = of_lost[k]
    if places or comes_first(first_fault[0], slabs.fault[s, 0]):  # new places begin a new report
        slabs.fault[s, 0] = first_fault[0]
        slabs.fault[s, 1] = first_fault[1]


@kernel(inner=True)
def _slab(s, points, dt, which):
    """Execute the pass `points` (`PassPoints`) on the points of slab s (a block of grid cells) over a step dt [s]; which:
    see `each_point`. Each part is a kernel, called for each block and shared with other passes: with the same law, or with
    the same shape functions."""
    slabs, evaluation, accounting = points.accounting.slabs, points.evaluation, points.accounting
    if slabs.first[s] == slabs.first[s + 1]:
        return
    KEPT, GATHERED = size(evaluation.read_like), size(evaluation.known_like) + size(evaluation.gathered_like)
    SUMS, columns = KEPT + size(evaluation.found_like.kept), size(evaluation.found_like.sums)
    FAULT = SUMS + columns + 1
    COLUMNS = max(FAULT + 2, KEPT + GATHERED)
    c, sums, of_lost, first_fault = zeros(WIDTH * COLUMNS), zeros((columns + 3) * LANES), zeros(columns), indices(2)
    functions_found, first_node = zeros(WIDTH * size(functions_like(points.gathering.functions))), indices(BLOCK)
    weights, bounds, vectors = numbers(WIDTH * WEIGHTS), bounds_of(slabs, s), 0
    first_fault[0] = first_fault[1] = 0
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        call_kernel(fetch_block, points.read, start, n, c, 0)
        vectors += call_kernel(_gather, points.gathering, start, n, KEPT, functions_found, first_node, c)
        add_to_cells(points.to_cells, evaluation, n, c)
        call_kernel(_evaluate, evaluation, dt, n, c)
        sound = call_kernel(
            _account, accounting, points.places, points.largest >= 0, columns, KEPT, SUMS, bounds, start, n, c, sums, of_lost,
            first_fault,
        )  # fmt: skip
        call_kernel(keep_block, points.kept, FAULT, sound, start, n, c, KEPT * WIDTH)
        if which:
            call_kernel(add_block, points.giving, start, n, functions_found, first_node, weights, which)
    call_kernel(_report, s, slabs, points.places, points.sums, columns, points.largest, sums, of_lost, first_fault, vectors)


@kernel()
def _each_point(n, points, dt):
    joint_for(_slab, n, points, dt, 0)


@kernel()
def _each_point_by_colour(n, points, dt, which):
    joint_by_colour(_slab, n, points.accounting.slabs.across, points, dt, which)


def each_point(points: Bundle, dt: float, which: int = 0) -> None:
    """Execute a pass, built by `pass_points`, on the points of a body, over a step dt [s].

    which: contributions to the nodes that are added: `gifts.FIRST`, `SECOND`, their sum, or 0 for none. Fills the declared
    columns of `Slabs.sums`, VECTORS and the faults, and, for a pass that moves points, `left_slab` and `of_lost`.
    """
    n = len(points.accounting.slabs.layers)
    if points.by_colour:  # always, so that in a joint region it is one kind of loop, before or after others of the body
        joint_region.give(
            lambda: _each_point_by_colour(n, points, dt, which),
            lambda: arrays_given(points.giving.gives, which) + arrays_given(points.to_cells),
        )
    else:
        _each_point(n, points, dt)
