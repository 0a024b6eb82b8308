"""The nodes of membrane elements: their equation of motion, and what they bring to the grid.

`mapped` is the bundle of a body as in `pellucid.grid.transfer`. The works of a step are those of its impulses along the mean of
the velocities before and after it, so that their sum is the change of kinetic energy exactly.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np
from numba import prange
from numpy import uintp

from pellucid.approximants.axis import axis_weights
from pellucid.grid.points import OK, RATE
from pellucid.grid.transfer import placed
from pellucid.jit import kernel

INTERNAL, GRAVITY, SUPPORT, LOAD, CONTACT, WORKS = range(6)
CONTACTING, LOADING, EXTRA_ROWS = range(3)  # rows of impulses before those of what is prescribed
SHORT = 1.0 - 1e-9  # of the way to a wall, which rounding must not lead through


class NodeForces(NamedTuple):
    """What acts on the nodes of elements over a step."""

    internal: np.ndarray  # (n, 3) of stress and hourglass control [N]
    external: np.ndarray  # (n, 3) [N]
    prescribed: np.ndarray  # (n, 3) 0 where free, else 1 + the row of `velocity`
    velocity: np.ndarray  # (rows, 3) prescribed velocities [m/s]
    walls: np.ndarray  # (3, 2) lower and upper faces of the grid that let no node through: 0 or 1 + the row of their support
    work: np.ndarray  # (slabs, WORKS + 3 (EXTRA_ROWS + rows)) works [J] and impulses [N s] of each slab


@kernel()
def _at_wall(walls, velocity, lattice, place, d, new, dt):
    """The wall that a node would pass with the velocity `new` along d, 0 or 1 + its row, and the velocity that it then has."""
    held, goal = 0, 0.0
    below, above = lattice.lower[d] - place, lattice.lower[d] + lattice.counts[d] / lattice.inverse_cell - place
    if walls[d, 0] > 0 and dt * new < below:
        held = walls[d, 0]
        goal = max(SHORT * below / dt, velocity[held - 1, d])
    elif walls[d, 1] > 0 and dt * new > above:
        held = walls[d, 1]
        goal = min(SHORT * above / dt, velocity[held - 1, d])
    return held, goal


@kernel()
def held_to(acting, points, lattice, p, d, old, new, dt, s):
    """What a change of velocity from old to new along d comes to where something holds the node, and the mean over it.

    Books what holds it: its work along that mean, its impulse.
    """
    _, _, prescribed, velocity, walls, work = acting.content[0]
    held, mean = prescribed[p, d], 0.5 * (old + new)
    goal = velocity[held - 1, d] if held > 0 else 0.0
    if held == 0:
        held, goal = _at_wall(walls, velocity, lattice, points.position[p, d], d, new, dt)
    if held > 0:
        reaction = points.mass[p] * (goal - new)
        new = goal
        mean = 0.5 * (old + new)
        work[s, SUPPORT] += reaction * mean
        work[s, WORKS + 3 * (EXTRA_ROWS + held - 1) + d] += reaction
    return new, mean


@kernel()
def _update_velocities_slab(mapped, acting, gravity, dt, s):
    fn, _, lattice, nodes, points, slabs, _ = mapped.content
    internal, external, _, _, _, work = acting.content[0]
    x, v, contact = points.position, points.velocity, nodes.contact
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for column in range(work.shape[1]):
        work[s, column] = 0.0
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        i, wx, _ = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, _ = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, _ = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        cx = cy = cz = 0.0
        for a in range(len(wx)):
            for b in range(len(wy)):
                row = (i + a) * stride[0] + (j + b) * stride[1] + k * stride[2]
                for c in range(len(wz)):
                    I = uintp(row + c * stride[2])
                    w = wx[a] * wy[b] * wz[c]
                    cx += w * contact[I, 0]
                    cy += w * contact[I, 1]
                    cz += w * contact[I, 2]
        touch = (cx, cy, cz)
        m = points.mass[p]
        for d in range(3):
            old = v[p, d]
            free = old + dt * ((internal[p, d] + external[p, d]) / m + gravity[d]) + touch[d]
            v[p, d], mean = held_to(acting, points, lattice, p, d, old, free, dt, s)
            work[s, INTERNAL] += dt * internal[p, d] * mean
            work[s, GRAVITY] += dt * m * gravity[d] * mean
            work[s, LOAD] += dt * external[p, d] * mean
            work[s, CONTACT] += m * touch[d] * mean
            work[s, WORKS + 3 * CONTACTING + d] += m * touch[d]
            work[s, WORKS + 3 * LOADING + d] += dt * external[p, d]


@kernel(parallel=True)
def update_velocities(n, mapped, acting, gravity, dt):
    """New velocities of the nodes of n slabs: v + dt (f/m + g) + Σ N_I contact_I, then what is prescribed.

    Lian, Liu & Zhang 2014, eqs. 46 and 59. acting: the bundle of `NodeForces`.
    """
    for s in prange(n):
        _update_velocities_slab(mapped, acting, gravity, dt, s)


@kernel()
def _update_positions_slab(mapped, dt, s):
    _, _, lattice, _, points, slabs, _ = mapped.content
    x, v = points.position, points.velocity
    lowest, highest = slabs.layer[s] - 1.0, slabs.layer[s + 1] + 1.0
    left_slab = first_fault = at_fault = 0
    fastest = 0.0
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        vx, vy, vz = v[p, 0], v[p, 1], v[p, 2]
        fault, beyond = placed(lattice, x, p, dt * vx, dt * vy, dt * vz, lowest, highest)
        left_slab |= beyond
        fastest = max(fastest, vx * vx + vy * vy + vz * vz)
        if fault != OK and first_fault == OK:
            first_fault = fault
            at_fault = signed
    slabs.left_slab[s] = left_slab
    slabs.fault[s, 0] = first_fault
    slabs.fault[s, 1] = at_fault
    slabs.sums[s, RATE] = lattice.inverse_cell * sqrt(fastest)


@kernel(parallel=True)
def update_positions(n, mapped, dt):
    """New positions of the nodes of n slabs; cells that the fastest crosses in unit time [1/s] into RATE of the sums."""
    for s in prange(n):
        _update_positions_slab(mapped, dt, s)


@kernel()
def _spread_slab(mapped, values, target, s):
    fn, _, lattice, _, points, slabs, _ = mapped.content
    x = points.position
    h, low, n, stride = lattice.inverse_cell, lattice.lower, lattice.counts, lattice.strides
    for signed in range(slabs.first[s], slabs.first[s + 1]):
        p = uintp(signed)
        i, wx, _ = axis_weights(fn[0], (x[p, 0] - low[0]) * h, n[0])
        j, wy, _ = axis_weights(fn[1], (x[p, 1] - low[1]) * h, n[1])
        k, wz, _ = axis_weights(fn[2], (x[p, 2] - low[2]) * h, n[2])
        for a in range(len(wx)):
            for b in range(len(wy)):
                row = (i + a) * stride[0] + (j + b) * stride[1] + k * stride[2]
                for c in range(len(wz)):
                    I = uintp(row + c * stride[2])
                    w = wx[a] * wy[b] * wz[c]
                    for d in range(3):
                        target[I, d] += w * values[p, d]


@kernel(parallel=True)
def spread(n, mapped, values, target):
    """Add forces at the nodes of n slabs [N], shape (points, 3), to those at the nodes of the grid, shape (nodes, 3)."""
    for colour in range(2):
        for half in prange((n + 1 - colour) // 2):
            _spread_slab(mapped, values, target, 2 * half + colour)
