"""Driven points: material points with prescribed velocity and position, and how they constrain the nodes.

The kernels take a body as in `pellucid.grid.transfer`, the bundle of a `DrivenPoints`, and that of
the `DrivenNodes` of `pellucid.grid.actions`.
"""

from typing import NamedTuple

import numpy as np
from numpy import intp, uintp

from pellucid.grid.lattice import LARGEST_STENCIL
from pellucid.grid.passes.blocks import about_lanes, fetch, find_functions, functions_like
from pellucid.grid.passes.places import bounds_of, placed
from pellucid.grid.points import OK, place_of
from pellucid.grid.stencil import add_shares, node_at
from pellucid.jit import kernel, pointwise
from pellucid.jit.columns import BLOCK, WIDTH, size
from pellucid.jit.local import indices, numbers, zeros
from pellucid.jit.parallel import joint_by_colour, joint_for, parallel_by_colour, parallel_for
from pellucid.jit.vector import LANES, load, splat, store, total
from pellucid.tensors import ZERO_VECTOR

WORK, LOSS, IMPULSE = range(3)  # columns of what a slab takes; impulses x, y, z of each motion from IMPULSE on
SHARES = LARGEST_STENCIL**3 * LANES  # numbers of the vectors in which the nodes of a run take their shares of its mass


class DrivenPoints(NamedTuple):
    """Which points of a body follow which prescribed motion, where these lead, and what they take."""

    driven: np.ndarray  # (n,) the number of the point's motion plus one, 0 where it is free
    start: np.ndarray  # (n, 3) first position [m]
    velocity: np.ndarray  # (motions, 3) over this step [m/s]
    displacement: np.ndarray  # (motions, 3) at its end [m]
    axes: np.ndarray  # (motions, 3) 1 for each axis that the motion prescribes
    taken: np.ndarray  # (slabs, IMPULSE + 3 motions) work and loss [J], impulses [N s]


@pointwise
def _run_end(first_node, motion, q, n):
    """The end of the run of points with the same nodes and the same motion that begins at point q of n points."""
    end, node, number = q + 1, first_node[q], motion[q]
    while end < n and first_node[end] == node and motion[end] == number:
        end += 1
    return end


@pointwise
def _add_run(functions, found, first_node, index, mass, start, q, end, m, shares):
    """Add the masses of the points q to `end` of a run to what their nodes share of it; the nodes as a stencil.

    m: a column for masses, zero where a vector reaches beyond the run.
    """
    for r in range(q, end):
        m[uintp(r)] = mass[place_of(index, start + r)]
    for r in range(end, end + LANES):
        m[uintp(r)] = 0.0
    about = about_lanes(functions, found, first_node, q)
    for r in range(q, end, LANES):
        add_shares(about_lanes(functions, found, first_node, r), load(m, r), shares)
    return about


@pointwise
def _take_share(shares, number):
    """The share of a node of a run, which is zero from then on."""
    share = total(load(shares, number * LANES))
    store(shares, number * LANES, splat(0.0))
    return share


@kernel(inner=True)
def _constrain_nodes_slab(s, mapped, drive, nodes):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    driven, velocity, axes = drive.driven, drive.velocity, drive.axes
    mass, momentum = nodes.mass, nodes.momentum
    if slabs.first[s] == slabs.first[s + 1]:
        return
    found, first_node = zeros(WIDTH * size(functions_like(functions))), indices(BLOCK)
    place, motion, m, shares = numbers(WIDTH * size(ZERO_VECTOR)), indices(BLOCK), numbers(WIDTH), zeros(SHARES)
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch(index, ZERO_VECTOR, points.position, start, n, place, 0)
        find_functions(functions, lattice, n, place, 0, found, first_node)
        for q in range(n):
            motion[q] = driven[place_of(index, start + q)]
        end = 0
        while end < n:
            q, k = end, uintp(motion[end] - 1)
            end = _run_end(first_node, motion, q, n)
            if motion[q] == 0:
                continue
            about, number = _add_run(functions, found, first_node, index, points.mass, start, q, end, m, shares), 0
            for a in range(len(about.wx)):
                for b in range(len(about.wy)):
                    for c in range(len(about.wz)):
                        I, w = node_at(about, lattice, a, b, c), _take_share(shares, number)
                        number += 1
                        for d in range(3):
                            if axes[k, d]:
                                mass[I, d] += w
                                momentum[I, d] += w * velocity[k, d]


@kernel()
def constrain_nodes(n, mapped, drive, nodes):
    """Mass and prescribed momentum of the driven points of n slabs to the nodes."""
    parallel_by_colour(_constrain_nodes_slab, n, mapped.slabs.across, mapped, drive, nodes)


@pointwise
def _impulse_on_nodes(about, lattice, nodal_impulse, shares):
    """Of a run, from the impulses on unit mass of its nodes and their shares of its mass, which are zero from then on."""
    x = y = z = 0.0
    number = 0
    for a in range(len(about.wx)):
        for b in range(len(about.wy)):
            for c in range(len(about.wz)):
                I, w = node_at(about, lattice, a, b, c), _take_share(shares, number)
                number += 1
                x += w * nodal_impulse[I, 0]
                y += w * nodal_impulse[I, 1]
                z += w * nodal_impulse[I, 2]
    return x, y, z


@kernel(inner=True)
def _prescribe_velocities_slab(s, mapped, drive, nodes):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    driven, velocity, axes, taken = drive.driven, drive.velocity, drive.axes, drive.taken
    v, nodal_impulse = points.velocity, nodes.impulse
    for column in range(taken.shape[1]):
        taken[s, column] = 0.0
    if slabs.first[s] == slabs.first[s + 1]:
        return
    found, first_node = zeros(WIDTH * size(functions_like(functions))), indices(BLOCK)
    place, motion, m, shares = numbers(WIDTH * size(ZERO_VECTOR)), indices(BLOCK), numbers(WIDTH), zeros(SHARES)
    for start in range(slabs.first[s], slabs.first[s + 1], BLOCK):
        n = min(BLOCK, slabs.first[s + 1] - start)
        fetch(index, ZERO_VECTOR, points.position, start, n, place, 0)
        find_functions(functions, lattice, n, place, 0, found, first_node)
        for q in range(n):
            motion[q] = driven[place_of(index, start + q)]
        end = 0
        while end < n:
            q, k = end, uintp(motion[end] - 1)
            end = _run_end(first_node, motion, q, n)
            if motion[q] == 0:
                continue
            about = _add_run(functions, found, first_node, index, points.mass, start, q, end, m, shares)
            on_nodes = _impulse_on_nodes(about, lattice, nodal_impulse, shares)
            for d in range(3):
                if axes[k, d]:
                    goal, work, loss, impulse = velocity[k, d], 0.0, 0.0, on_nodes[d]
                    for r in range(q, end):
                        p = place_of(index, start + r)
                        apart = goal - v[p, d]
                        change = m[uintp(r)] * apart
                        work += change * goal
                        loss += 0.5 * change * apart
                        impulse += change
                        v[p, d] = goal
                    taken[s, WORK] += work
                    taken[s, LOSS] += loss
                    taken[s, IMPULSE + 3 * k + d] += impulse


@kernel()
def prescribe_velocities(n, mapped, drive, nodes):
    """Prescribed velocities of the driven points; impulses and energies that this takes, those on the nodes included."""
    joint_by_colour(_prescribe_velocities_slab, n, mapped.slabs.across, mapped, drive, nodes)


@pointwise
def _report(slabs, s, beyond, fault, p):
    """Mark that points of slab s left it, and the first fault with its point; earlier faults of the slab stay."""
    slabs.left_slab[s] |= beyond
    if fault != OK and slabs.fault[s, 0] == OK:
        slabs.fault[s, 0] = fault
        slabs.fault[s, 1] = p


@kernel(inner=True)
def _prescribe_positions_slab(s, mapped, drive):
    lattice, index, slabs = mapped.lattice, mapped.index, mapped.slabs
    driven, start, displacement, axes = drive.driven, drive.start, drive.displacement, drive.axes
    x = mapped.points.position
    bounds = bounds_of(slabs, s)
    left = first_fault = at_fault = 0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        k = uintp(driven[p] - 1)
        if driven[p] == 0:
            continue
        dx = start[p, 0] + displacement[k, 0] - x[p, 0] if axes[k, 0] else 0.0
        dy = start[p, 1] + displacement[k, 1] - x[p, 1] if axes[k, 1] else 0.0
        dz = start[p, 2] + displacement[k, 2] - x[p, 2] if axes[k, 2] else 0.0
        fault, beyond = placed(lattice, x, p, dx, dy, dz, bounds)
        left |= beyond
        if fault != OK and first_fault == OK:
            first_fault = fault
            at_fault = intp(p)  # type: ignore[assignment]
    _report(slabs, s, left, first_fault, at_fault)


@kernel()
def prescribe_positions(n, mapped, drive):
    """Prescribed positions of the driven points."""
    joint_for(_prescribe_positions_slab, n, mapped, drive)


@kernel(inner=True)
def _move_points_slab(s, mapped, target):
    lattice, index, slabs = mapped.lattice, mapped.index, mapped.slabs
    x = mapped.points.position
    bounds = bounds_of(slabs, s)
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        dx, dy, dz = target[p, 0] - x[p, 0], target[p, 1] - x[p, 1], target[p, 2] - x[p, 2]
        fault, beyond = placed(lattice, x, p, dx, dy, dz, bounds)
        _report(slabs, s, beyond, fault, p)


@kernel()
def move_points_to(n, mapped, target):
    """The points of n slabs to the places `target` [m], shape (points, 3)."""
    parallel_for(_move_points_slab, n, mapped, target)
