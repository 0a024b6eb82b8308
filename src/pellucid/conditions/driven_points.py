"""Driven points: material points with prescribed velocity and position, and how they constrain the nodes.

The kernels take a body as in `pellucid.grid.transfer`, the bundle of a `DrivenPoints`, and that of
the `DrivenNodes` of `pellucid.grid.actions`.
"""

from typing import NamedTuple

import numpy as np

from pellucid.grid.points import OK, place_of
from pellucid.grid.stencil import gather, node_at, stencil
from pellucid.grid.transfer import placed
from pellucid.jit import kernel, pointwise
from pellucid.jit.parallel import parallel_by_colour, parallel_for

WORK, LOSS = range(2)  # columns of the energies of a slab


class DrivenPoints(NamedTuple):
    """Which points of a body follow which prescribed motion, where these lead, and their impulses and energies."""

    driven: np.ndarray  # (n,) the number of the point's motion plus one, 0 where it is free
    start: np.ndarray  # (n, 3) first position [m]
    velocity: np.ndarray  # (motions, 3) over this step [m/s]
    displacement: np.ndarray  # (motions, 3) at its end [m]
    axes: np.ndarray  # (motions, 3) 1 for each axis that the motion prescribes
    impulse: np.ndarray  # (slabs, motions, 3) [N s]
    energy: np.ndarray  # (slabs, 2) [J]


@kernel(inner=True)
def _constrain_nodes_slab(s, mapped, drive, nodes):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    driven, velocity, axes = drive.driven, drive.velocity, drive.axes
    mass, momentum = nodes.mass, nodes.momentum
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if driven[p] == 0:
            continue
        motion = driven[p] - 1
        about = stencil(functions, lattice, points.position, p)
        wx, wy, wz = about.wx, about.wy, about.wz
        m = points.mass[p]
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    I = node_at(about, lattice, a, b, c)
                    w = wx[a] * wy[b] * wz[c] * m
                    for d in range(3):
                        if axes[motion, d]:
                            mass[I, d] += w
                            momentum[I, d] += w * velocity[motion, d]


@kernel()
def constrain_nodes(n, mapped, drive, nodes):
    """Mass and prescribed momentum of the driven points of n slabs to the nodes."""
    parallel_by_colour(_constrain_nodes_slab, n, mapped, drive, nodes)


@kernel(inner=True)
def _prescribe_velocities_slab(s, mapped, drive, nodes):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    points, slabs = mapped.points, mapped.slabs
    driven, velocity, axes, impulse, energy = drive.driven, drive.velocity, drive.axes, drive.impulse, drive.energy
    v, nodal_impulse = points.velocity, nodes.impulse
    work = loss = 0.0
    impulse[s] = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        if driven[p] == 0:
            continue
        motion = driven[p] - 1
        on_nodes = gather(stencil(functions, lattice, points.position, p), lattice, nodal_impulse)
        m = points.mass[p]
        for d in range(3):
            if axes[motion, d] == 0:
                continue
            goal = velocity[motion, d]
            apart = goal - v[p, d]
            work += m * apart * goal
            loss += 0.5 * m * apart * apart
            v[p, d] = goal
            impulse[s, motion, d] += m * (apart + on_nodes[d])
    energy[s, WORK] = work
    energy[s, LOSS] = loss


@kernel()
def prescribe_velocities(n, mapped, drive, nodes):
    """Prescribed velocities of the driven points; impulses and energies that this takes, those on the nodes included."""
    parallel_for(_prescribe_velocities_slab, n, mapped, drive, nodes)


@pointwise
def _shift(lattice, x, slabs, s, p, step):
    """Move point p of slab s by `step` [m], and mark that it left its slab or the grid; earlier faults of the slab stay."""
    lowest, highest = slabs.layer[s] - 1.0, slabs.layer[s + 1] + 1.0
    fault, beyond = placed(lattice, x, p, step[0], step[1], step[2], lowest, highest)
    slabs.left_slab[s] |= beyond
    if fault != OK and slabs.fault[s, 0] == OK:
        slabs.fault[s, 0] = fault
        slabs.fault[s, 1] = p


@kernel(inner=True)
def _prescribe_positions_slab(s, mapped, drive):
    lattice, index, slabs = mapped.lattice, mapped.index, mapped.slabs
    driven, start, displacement, axes = drive.driven, drive.start, drive.displacement, drive.axes
    x = mapped.points.position
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
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
        _shift(lattice, x, slabs, s, p, step)


@kernel()
def prescribe_positions(n, mapped, drive):
    """Prescribed positions of the driven points."""
    parallel_for(_prescribe_positions_slab, n, mapped, drive)


@kernel(inner=True)
def _move_points_slab(s, mapped, target):
    lattice, index, slabs = mapped.lattice, mapped.index, mapped.slabs
    x = mapped.points.position
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        _shift(lattice, x, slabs, s, p, (target[p, 0] - x[p, 0], target[p, 1] - x[p, 1], target[p, 2] - x[p, 2]))


@kernel()
def move_points_to(n, mapped, target):
    """The points of n slabs to the places `target` [m], shape (points, 3)."""
    parallel_for(_move_points_slab, n, mapped, target)
