"""Scatter from points to nodes, generic in shape functions and transfer; motion of points by the nodes.

Work is shared by slabs. Slabs of one colour never reach the same node, so no scatter needs atomics, and every nodal
sum is added in the order of the points: the same bits on any number of threads.

The kernels take a body as the bundle of its `MappedPoints`. Flags are integers 0 or 1.
"""

from math import inf, sqrt

from numpy import intp

from pellucid.grid.blocks import fetch, find_functions, functions_like
from pellucid.grid.points import (
    KINETIC,
    LOST,
    MOMENTUM_X,
    MOMENTUM_Y,
    MOMENTUM_Z,
    NOT_FINITE,
    OK,
    SPEED,
    place_of,
)
from pellucid.grid.scatter import WEIGHTS, add_block
from pellucid.grid.stencil import gather, stencil
from pellucid.jit import kernel, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.columns import BLOCK, WIDTH, size
from pellucid.jit.local import indices, numbers
from pellucid.jit.parallel import joint_by_colour, parallel_for
from pellucid.tensors import ZERO_VECTOR


@kernel(inner=True)
def _scatter_slab(s, mapped, inertia, force, counted):
    functions, lattice, points, slabs, index = mapped.functions, mapped.lattice, mapped.points, mapped.slabs, mapped.index
    if slabs.first[s] == slabs.first[s + 1]:
        return
    found, first_node, c = numbers(WIDTH * size(functions_like(functions))), indices(BLOCK), numbers(WIDTH * size(ZERO_VECTOR))
    weights = numbers(WIDTH * WEIGHTS)
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch(index, ZERO_VECTOR, points.position, start, n, c, 0)
        find_functions(functions, lattice, n, c, 0, found, first_node)
        add_block(functions, mapped, start, n, found, first_node, weights, (inertia, force, counted))


@kernel()
def _scatter(n, mapped, inertia, force, counted):
    joint_by_colour(_scatter_slab, n, mapped.slabs.across, mapped, inertia, force, counted)


def scatter(n: int, mapped: Bundle, inertia: int, force: int) -> None:
    """Map mass and momentum (where `inertia`) and internal forces -Σ V σ ∇N (where `force`) of n slabs to the nodes."""
    _scatter(n, mapped, inertia, force, 1.0)


def scatter_momentum(n: int, mapped: Bundle) -> None:
    """Momentum alone of the points of n slabs to the nodes, after their velocities were changed (MUSL)."""
    _scatter(n, mapped, 1, 0, 0.0)


@pointwise
def bounds_of(slabs, s):
    """Between which places the points of slab s may move, in cells: along the slowest axis, and along that of the cuts."""
    return slabs.bounds[s, 0], slabs.bounds[s, 1], slabs.bounds[s, 2], slabs.bounds[s, 3]


@pointwise
def strays(lattice, X, Y, Z, bounds):
    """Whether a point at X, Y, Z, in cells from the walls, lies beyond the bounds of its slab: 1.0 or 0.0."""
    main, second = lattice.slab_axis, lattice.cut_axis
    along = X if main == 0 else (Y if main == 1 else Z)
    across = X if second == 0 else (Y if second == 1 else Z)
    beyond = 1.0 if along < bounds[0] else 0.0
    beyond = 1.0 if along >= bounds[1] else beyond
    beyond = 1.0 if across < bounds[2] else beyond
    return 1.0 if across >= bounds[3] else beyond


@pointwise
def placed(lattice, x, p, dx, dy, dz, bounds):
    """Move point p; the fault of its new position, and 1 where it lies beyond the bounds of its slab."""
    h, low, n = lattice.inverse_cell, lattice.lower, lattice.counts
    x[p, 0] += dx
    x[p, 1] += dy
    x[p, 2] += dz
    X, Y, Z = (x[p, 0] - low[0]) * h, (x[p, 1] - low[1]) * h, (x[p, 2] - low[2]) * h
    beyond = 1 if strays(lattice, X, Y, Z, bounds) > 0.0 else 0
    if X >= 0.0 and n[0] >= X and Y >= 0.0 and n[1] >= Y and Z >= 0.0 and n[2] >= Z:
        return OK, beyond
    return (LOST if abs(X + Y + Z) < inf else NOT_FINITE), beyond


@kernel(inner=True)
def _update_positions_slab(s, mapped, velocity, dt):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    bounds = bounds_of(slabs, s)
    left_slab = first_fault = at_fault = 0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        v = gather(stencil(functions, lattice, x, p), lattice, velocity)
        fault, beyond = placed(lattice, x, p, dt * v[0], dt * v[1], dt * v[2], bounds)
        left_slab |= beyond
        if fault != OK and (first_fault == OK or (first_fault == LOST and fault != LOST)):
            first_fault = fault
            at_fault = intp(p)  # type: ignore[assignment]
    slabs.left_slab[s] = left_slab
    if first_fault != OK:  # what `update_stress` found earlier in the step stays
        slabs.fault[s, 0] = first_fault
        slabs.fault[s, 1] = at_fault


@kernel()
def update_positions(n, mapped, velocity, dt):
    """New positions alone, by nodal velocities [m/s], shape (nodes, 3), for what is strained otherwise or before it moves."""
    parallel_for(_update_positions_slab, n, mapped, velocity, dt)


@kernel(inner=True)
def _sum_slab(s, mapped):
    points, slabs, index = mapped.points, mapped.slabs, mapped.index
    v = points.velocity
    kinetic = px = py = pz = speed = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        m = points.mass[p]
        vv = v[p, 0] * v[p, 0] + v[p, 1] * v[p, 1] + v[p, 2] * v[p, 2]
        kinetic += 0.5 * m * vv
        px += m * v[p, 0]
        py += m * v[p, 1]
        pz += m * v[p, 2]
        speed += m * sqrt(vv)
    slabs.sums[s, KINETIC] = kinetic
    slabs.sums[s, MOMENTUM_X] = px
    slabs.sums[s, MOMENTUM_Y] = py
    slabs.sums[s, MOMENTUM_Z] = pz
    slabs.sums[s, SPEED] = speed


@kernel(inner=True)
def _add_increments_slab(s, mapped, increment, reached):
    if not reached[s]:
        return
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    v = points.velocity
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        change = gather(stencil(functions, lattice, points.position, p), lattice, increment)
        for d in range(3):
            v[p, d] += change[d]
    _sum_slab(s, mapped)


@kernel()
def add_increments(n, mapped, increment, reached):
    """Add velocity increments of nodes [m/s], shape (nodes, 3), to points of those of n slabs that are `reached`, shape (n,);
    kinetic energy and momentum of these slabs."""
    parallel_for(_add_increments_slab, n, mapped, increment, reached)


@kernel()
def sum_momentum(n, mapped):
    """Kinetic energy and momentum of the points of n slabs, after their velocities were changed."""
    joint_by_colour(_sum_slab, n, mapped.slabs.across, mapped)
