"""Driven points: material points whose velocity and place are prescribed, and what they do to the nodes.

`mapped` is the bundle of a body as in `transfer`, `drive` is (driven, start, velocity, displacement, axes, impulse, energy):
for each point the number of its motion plus one, 0 where it is free, and its first position [m]; for each motion its velocity
over this step [m/s], its displacement at the end [m], and 1 for each axis that it prescribes; for each slab the impulses [N s]
and the energies [J] of this step.
"""

from numba import prange
from numpy import uintp

from pellucid.approximants.axis import axis_weights
from pellucid.grid.points import OK
from pellucid.grid.transfer import placed
from pellucid.jit import kernel, pointwise

WORK, LOSS = range(2)  # columns of the energies of a slab


@kernel()
def _constrain_nodes_slab(mapped, drive, outside, s):
    fn, _, lattice, _, points, slabs, _ = mapped.content
    driven, _, velocity, _, axes, _, _ = drive.content
    x, mass, momentum = points.position, outside.driven_mass, outside.driven_momentum
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        if driven[p] == 0:
            continue
        motion = driven[p] - 1
        i, wx, _ = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, _ = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, _ = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        m = points.mass[p]
        for a in range(len(wx)):
            for b in range(len(wy)):
                row = (i + a) * stride[0] + (j + b) * stride[1] + k * stride[2]
                for c in range(len(wz)):
                    I = uintp(row + c * stride[2])
                    w = wx[a] * wy[b] * wz[c] * m
                    for d in range(3):
                        if axes[motion, d]:
                            mass[I, d] += w
                            momentum[I, d] += w * velocity[motion, d]


@kernel(parallel=True)
def constrain_nodes(n, mapped, drive, outside):
    """Mass and prescribed momentum of the driven points of n slabs to the nodes."""
    for colour in range(2):
        for half in prange((n + 1 - colour) // 2):
            _constrain_nodes_slab(mapped, drive, outside.content[0], 2 * half + colour)


@kernel()
def _prescribe_velocities_slab(mapped, drive, outside, s):
    fn, _, lattice, _, points, slabs, _ = mapped.content
    driven, _, velocity, _, axes, impulse, energy = drive.content
    x, v = points.position, points.velocity
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    work = loss = 0.0
    impulse[s] = 0.0
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        if driven[p] == 0:
            continue
        motion = driven[p] - 1
        i, wx, _ = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, _ = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, _ = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        m = points.mass[p]
        for d in range(3):
            if axes[motion, d] == 0:
                continue
            goal = velocity[motion, d]
            apart = goal - v[p, d]
            work += m * apart * goal
            loss += 0.5 * m * apart * apart
            v[p, d] = goal
            on_nodes = 0.0
            for a in range(len(wx)):
                for b in range(len(wy)):
                    row = (i + a) * stride[0] + (j + b) * stride[1] + k * stride[2]
                    for c in range(len(wz)):
                        on_nodes += wx[a] * wy[b] * wz[c] * outside.impulse[uintp(row + c * stride[2]), d]
            impulse[s, motion, d] += m * (apart + on_nodes)
    energy[s, WORK] = work
    energy[s, LOSS] = loss


@kernel(parallel=True)
def prescribe_velocities(n, mapped, drive, outside):
    """Prescribed velocities of the driven points; impulses and energies that this takes, those on the nodes included."""
    for s in prange(n):
        _prescribe_velocities_slab(mapped, drive, outside.content[0], s)


@pointwise
def _shift(lattice, x, slabs, s, signed, step):
    """Move point `signed` of slab s by `step` [m], and note where that leads astray; earlier faults of the slab stay."""
    lowest, highest = slabs.layer[s] - 1.0, slabs.layer[s + 1] + 1.0
    fault, beyond = placed(lattice, x, uintp(signed), step[0], step[1], step[2], lowest, highest)
    slabs.left_slab[s] |= beyond
    if fault != OK and slabs.fault[s, 0] == OK:
        slabs.fault[s, 0] = fault
        slabs.fault[s, 1] = signed


@kernel()
def _prescribe_positions_slab(mapped, drive, s):
    _, _, lattice, _, points, slabs, _ = mapped.content
    driven, start, _, displacement, axes, _, _ = drive.content
    x = points.position
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        if driven[p] == 0:
            continue
        motion = driven[p] - 1
        goal = displacement[motion]
        to = axes[motion]
        step = (
            start[p, 0] + goal[0] - x[p, 0] if to[0] else 0.0,
            start[p, 1] + goal[1] - x[p, 1] if to[1] else 0.0,
            start[p, 2] + goal[2] - x[p, 2] if to[2] else 0.0,
        )
        _shift(lattice, x, slabs, s, signed, step)


@kernel(parallel=True)
def prescribe_positions(n, mapped, drive):
    """Prescribed positions of the driven points."""
    for s in prange(n):
        _prescribe_positions_slab(mapped, drive, s)


@kernel()
def _move_points_slab(mapped, target, s):
    _, _, lattice, _, points, slabs, _ = mapped.content
    x = points.position
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        _shift(lattice, x, slabs, s, signed, (target[p, 0] - x[p, 0], target[p, 1] - x[p, 1], target[p, 2] - x[p, 2]))


@kernel(parallel=True)
def move_points_to(n, mapped, target):
    """The points of n slabs to the places `target` [m], shape (points, 3)."""
    for s in prange(n):
        _move_points_slab(mapped, target, s)
