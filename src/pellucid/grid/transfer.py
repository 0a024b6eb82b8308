"""Points moved by the nodes alone, velocity increments, and sums over the points.

The kernels take a body as the bundle of its `MappedPoints`.
"""

from math import sqrt

from numpy import intp

from pellucid.grid.passes.places import bounds_of, comes_first, placed
from pellucid.grid.points import KINETIC, MOMENTUM_X, MOMENTUM_Y, MOMENTUM_Z, OK, SPEED, place_of
from pellucid.grid.stencil import gather, stencil
from pellucid.jit import kernel
from pellucid.jit.parallel import joint_by_colour, parallel_for


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
        if comes_first(fault, first_fault):
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
