"""Kernels of the equation of motion of nodes in mesh order, with constraints, drag and works, and the power of
forces on nodes.

The work of an impulse is computed with the mean of the velocities before and after the step, so that the sum of all works
is exactly the change of kinetic energy. Nodes are divided into chunks whose number does not depend on the number of
threads.

Damping is a drag on the nodes, -c m v with the mean velocity of the step: v⁺ = k v + g Δt f/m with k = (1 - cΔt/2)/(1 +
cΔt/2) and g = 1/(1 + cΔt/2). Dynamic relaxation chooses k and g itself; without damping both are 1.
"""

from math import inf, sqrt
from typing import NamedTuple

import numpy as np

from pellucid.energy import CONTACT, DAMPING, FIRST_LOAD, FRICTION, GRAVITY, INTERNAL, MOTION, SUPPORT
from pellucid.grid.points import KINETIC, MOMENTUM_X, MOMENTUM_Y, MOMENTUM_Z, NOT_FINITE, OK, SPEED
from pellucid.jit import kernel, pointwise
from pellucid.jit.loops import parallel_loop
from pellucid.reductions import ordered_sum

SHORT = 1.0 - 1e-9  # largest fraction of the way to a wall, so that round-off moves no node through it


@pointwise
def at_wall(forces, place, d, new, dt):
    """Return three values for a node at the coordinate `place` [m] with the velocity `new` [m/s] along axis d: 1 + the row of
    the wall that it would pass in a step dt [s] (0: none), the velocity [m/s] with which it does not pass, and the end of the
    axis at which the wall is (0 lower, 1 upper).

    forces: data of `NodeForces`.
    """
    walls, rows = forces.walls, forces.rows
    row, goal, end = 0, 0.0, 0
    below, above = forces.faces[d, 0] - place, forces.faces[d, 1] - place
    if walls[d, 0] > 0 and dt * new < below:
        row = walls[d, 0]
        goal = max(SHORT * below / dt, rows[row - 1, d])
    elif walls[d, 1] > 0 and dt * new > above:
        row, end = walls[d, 1], 1
        goal = min(SHORT * above / dt, rows[row - 1, d])
    return row, goal, end


@pointwise
def _stopped(forces, p, d, new, dt):
    """Return, for node p with the velocity `new` [m/s] along axis d: 1 + the row of the wall that it would pass in a step dt
    [s] (0: none), the velocity [m/s] with which it does not pass, and the end of the axis at which the wall is (0 lower, 1
    upper).

    forces: data of `NodeForces`. There is no wall if a constraint prescribes the motion of the node along the axis.
    """
    return (0, 0.0, 0) if forces.prescribed[p, d] > 0 else at_wall(forces, forces.position[p, d], d, new, dt)


@pointwise
def friction_of_walls(forces, p, free, gain, dt, chunk):
    """Return the velocity change of node p by friction on walls, along x, y, z [m/s].

    forces: data of `NodeForces`; free: velocity of the node without walls [m/s]; gain: the factor g of `Drag`; dt: time step
    [s]. Adds the friction impulses and the work on the walls to the sums of the chunk. The caller subtracts the work on the
    node from the heat of friction.

    A node that would pass a wall is stopped at the wall by an impulse P. Friction then reduces its motion along the wall, by
    an impulse of at most μ P (see `pellucid.grid.nodal_conditions`).
    """
    m, first = forces.inertia[p] / gain, FIRST_LOAD + len(forces.loads) + 1
    x, y, z = 0.0, 0.0, 0.0
    for axis in range(3):
        row, goal, end = _stopped(forces, p, axis, free[axis], dt)
        most = forces.friction[axis, end] * m * abs(goal - free[axis]) if row > 0 else 0.0
        if not most > 0.0:
            continue
        wall = forces.rows[row - 1, 0], forces.rows[row - 1, 1], forces.rows[row - 1, 2]
        slides = (
            axis != 0 and forces.prescribed[p, 0] == 0 and _stopped(forces, p, 0, free[0], dt)[0] == 0,
            axis != 1 and forces.prescribed[p, 1] == 0 and _stopped(forces, p, 1, free[1], dt)[0] == 0,
            axis != 2 and forces.prescribed[p, 2] == 0 and _stopped(forces, p, 2, free[2], dt)[0] == 0,
        )
        ux = wall[0] - free[0] - x if slides[0] else 0.0
        uy = wall[1] - free[1] - y if slides[1] else 0.0
        uz = wall[2] - free[2] - z if slides[2] else 0.0
        whole = m * sqrt(ux * ux + uy * uy + uz * uz)
        share = 1.0 if whole <= most else most / whole
        more = share * ux, share * uy, share * uz
        x, y, z = x + more[0], y + more[1], z + more[2]
        for d in range(3):
            impulse = m * more[d]
            forces.work[chunk, first + 3 * (row - 1) + d] += impulse
            forces.work[chunk, SUPPORT] += impulse * wall[d]
            forces.work[chunk, FRICTION] += impulse * wall[d]
    return x, y, z


CHUNK = 512  # nodes
FASTEST, NODE_SUMS = SPEED + 1, SPEED + 2  # columns of the sums of a chunk, after those of the motion of points


class Drag(NamedTuple):
    """Drag on the nodes over a step Δt, as factors of velocity and acceleration: v⁺ = k v + g Δt f/m, with the velocities v and
    v⁺ before and after the step and the force f on a node of mass m.
    """

    keep: float  # k
    gain: float  # g


UNDAMPED = Drag(1.0, 1.0)


class NodeForces(NamedTuple):
    """Data of n nodes for the kernels of their equation of motion over a step: positions, velocities and masses, forces,
    prescribed velocities, walls of the grid, and sums of works.
    """

    position: np.ndarray  # (n, 3) nodal positions [m]
    velocity: np.ndarray  # (n, 3) nodal velocities [m/s]
    mass: np.ndarray  # (n,) masses on which gravity acts [kg]
    inertia: np.ndarray  # (n,) inertia [kg]: the masses, unless a relaxation scales them
    internal: np.ndarray  # (n, 3) internal forces: stress and hourglass control [N]
    loads: np.ndarray  # (channels, n, 3) external forces [N]
    gravity: np.ndarray  # (3,) applied gravity [m/s²]
    increment: np.ndarray  # (n, 3) velocity increments from contact [m/s]
    lead: np.ndarray  # (2, n, 3) velocity increments by supports and motions that act on the field [m/s]; (0, 0, 0) if none
    prescribed: np.ndarray  # (n, 3) 0 for free components, else 1 + the row in `rows`
    rows: np.ndarray  # (rows, 3) prescribed velocities [m/s]
    motions: tuple[int, int]  # first row of the prescribed motions in `rows`, and the row after the last; supports come before
    faces: np.ndarray  # (3, 2) coordinates of the lower and upper faces of the grid [m]
    walls: np.ndarray  # (3, 2) faces that no node can pass: 1 + the row of their support; 0 for other faces
    friction: np.ndarray  # (3, 2) friction coefficients of the faces in `walls`; empty without friction
    work: np.ndarray  # (chunks, ...) works, as in `pellucid.energy`, impulses of the constraints, other impulses


@kernel(inner=True)
def _constrained(forces, p, d, old, new, gain, dt, chunk):
    """Apply the constraints of node p along axis d to its new velocity. Returns the constrained velocity [m/s], the mean of
    the old and the constrained velocity, and the constraint impulse [N s].

    forces: data of `NodeForces`; old, new: velocities before and after the step without constraints [m/s]; gain: factor g of
    the drag; dt: time step [s]. Adds the impulse, and its work at the mean velocity, to the sums of the chunk.
    """
    row, mean, reaction = forces.prescribed[p, d], 0.5 * (old + new), 0.0
    goal = forces.rows[row - 1, d] if row > 0 else 0.0
    if row == 0:
        row, goal, _ = at_wall(forces, forces.position[p, d], d, new, dt)
    if row > 0:
        reaction = forces.inertia[p] * (goal - new) / gain
        new = goal
        mean = 0.5 * (old + new)
        first = FIRST_LOAD + len(forces.loads) + 1
        cause = MOTION if forces.motions[0] < row <= forces.motions[1] else SUPPORT
        forces.work[chunk, cause] += reaction * mean
        forces.work[chunk, first + 3 * (row - 1) + d] += reaction
    return new, mean, reaction


@pointwise
def _gained(forces, p, d, dt):
    """Return the velocity increment of node p along axis d over a step dt [s] by internal and external forces and gravity
    [m/s], and the external force on it [N]. forces: data of `NodeForces`.
    """
    m, external = forces.inertia[p], 0.0
    for k in range(len(forces.loads)):
        external += forces.loads[k, p, d]
    over_m = 1.0 / m
    return dt * ((forces.internal[p, d] + external) * over_m + forces.mass[p] * over_m * forces.gravity[d]), external


@pointwise
def _free(forces, p, d, drag, gained):
    """Return the velocity that node p has along axis d at the end of the step without constraints at the node [m/s].

    forces: data of `NodeForces`; drag: a `Drag`; gained: increment by forces, from `_gained` [m/s].
    """
    of_supports, of_motions = (forces.lead[0, p, d], forces.lead[1, p, d]) if len(forces.lead) > 0 else (0.0, 0.0)
    return drag.keep * forces.velocity[p, d] + drag.gain * (gained + of_supports + of_motions) + forces.increment[p, d]


@pointwise
def _rubbed(forces, p, drag, dt, chunk):
    """Return the velocity change of node p by the friction of walls over a step dt [s], along x, y, z [m/s]; see
    `friction_of_walls`. forces: data of `NodeForces`; drag: a `Drag`; chunk: chunk of nodes whose sums get work and impulses.
    """
    x, y, z = _gained(forces, p, 0, dt)[0], _gained(forces, p, 1, dt)[0], _gained(forces, p, 2, dt)[0]
    free = _free(forces, p, 0, drag, x), _free(forces, p, 1, drag, y), _free(forces, p, 2, drag, z)
    return friction_of_walls(forces, p, free, drag.gain, dt, chunk)


@parallel_loop()
def advance_velocities(chunk, forces, drag, dt):
    """Update the velocities of a chunk of nodes: v + dt (f/m + g), damped, plus the increment from contact, then the
    constraints; and sum works and impulses.

    Lian, Liu & Zhang 2014, eqs. 46 and 59. forces: data of `NodeForces`; drag: a `Drag`; dt: time step [s].
    """
    internal, loads, gravity, increment, work = forces.internal, forces.loads, forces.gravity, forces.increment, forces.work
    columns, led, rubs = FIRST_LOAD + len(loads), len(forces.lead) > 0, len(forces.friction) > 0
    behind = columns + 1 + 3 * len(forces.rows)
    total = of_internal = of_gravity = of_contact = of_support = of_motion = of_damping = of_friction = 0.0
    work[chunk, :] = 0.0
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(forces.mass))):
        m = forces.inertia[p]
        over_m = 1.0 / m
        share = forces.mass[p] * over_m
        total += forces.mass[p]
        rubbed = _rubbed(forces, p, drag, dt, chunk) if rubs else (0.0, 0.0, 0.0)
        for d in range(3):
            old, touch = forces.velocity[p, d], increment[p, d]
            of_supports, of_motions = (forces.lead[0, p, d], forces.lead[1, p, d]) if led else (0.0, 0.0)
            gained, external = _gained(forces, p, d, dt)
            free = _free(forces, p, d, drag, gained) + rubbed[d]
            forces.velocity[p, d], mean, reaction = _constrained(forces, p, d, old, free, drag.gain, dt, chunk)
            friction = m * rubbed[d] / drag.gain
            reaction += m * (of_supports + of_motions) + friction
            slowing = m * ((drag.keep - 1.0) * old + (drag.gain - 1.0) * gained) + (drag.gain - 1.0) * reaction
            of_internal += dt * internal[p, d] * mean
            of_gravity += dt * m * (share * gravity[d]) * mean
            of_contact += m * touch * mean
            of_support += m * of_supports * mean
            of_motion += m * of_motions * mean
            of_friction -= friction * mean
            of_damping -= slowing * mean
            for k in range(len(loads)):
                work[chunk, FIRST_LOAD + k] += dt * loads[k, p, d] * mean
            work[chunk, behind + d] += dt * external + slowing
    work[chunk, INTERNAL] += of_internal
    work[chunk, GRAVITY] += of_gravity
    work[chunk, CONTACT] += of_contact
    work[chunk, SUPPORT] += of_support
    work[chunk, MOTION] += of_motion
    work[chunk, DAMPING] += of_damping
    work[chunk, FRICTION] += of_friction
    work[chunk, columns] = total


@parallel_loop()
def add_velocities(chunk, forces, change, dt):
    """Add velocities `change` [m/s], shape (n, 3), to the advanced velocities of a chunk of nodes; the work of this change
    counts as contact work.

    forces: data of `NodeForces`; dt: time step [s]. The elements are strained over the whole step with the new velocities,
    on which the internal forces have not yet done work. Half of this work, with the forces at the start of the step, is
    subtracted from the contact work; the other half is `staggering` in `EnergyBudget`.
    """
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(forces.mass))):
        for d in range(3):
            if change[p, d] != 0.0:
                old = forces.velocity[p, d]
                new, mean, _ = _constrained(forces, p, d, old, old + change[p, d], 1.0, dt, chunk)
                forces.velocity[p, d] = new
                ahead = 0.5 * dt * forces.internal[p, d] * (new - old)
                forces.work[chunk, CONTACT] += forces.inertia[p] * change[p, d] * mean - ahead
                forces.work[chunk, INTERNAL] += ahead


@parallel_loop()
def sum_momentum(chunk, velocity, mass, sums):
    """Write the kinetic energy [J], momentum, Σ m|v| [kg m/s] and the largest speed [m/s] of a chunk of nodes to `sums`, shape
    (chunks, NODE_SUMS). velocity: [m/s], shape (n, 3); mass: [kg], shape (n,).
    """
    kinetic = px = py = pz = size = fastest = 0.0
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mass))):
        m, vx, vy, vz = mass[p], velocity[p, 0], velocity[p, 1], velocity[p, 2]
        vv = vx * vx + vy * vy + vz * vz
        kinetic += 0.5 * m * vv
        px += m * vx
        py += m * vy
        pz += m * vz
        size += m * sqrt(vv)
        fastest = max(fastest, vv)
    sums[chunk, KINETIC], sums[chunk, SPEED], sums[chunk, FASTEST] = kinetic, size, sqrt(fastest)
    sums[chunk, MOMENTUM_X], sums[chunk, MOMENTUM_Y], sums[chunk, MOMENTUM_Z] = px, py, pz


@parallel_loop()
def advance_positions(chunk, position, velocity, dt, fault):
    """Update the positions of a chunk of nodes over a step dt [s], and write code and number of the first node whose position
    is not finite to `fault`, shape (chunks, 2). position, velocity: [m], [m/s], shape (n, 3).
    """
    code = at_fault = 0
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(position))):
        total = 0.0
        for d in range(3):
            position[p, d] += dt * velocity[p, d]
            total += position[p, d]
        if not abs(total) < inf and code == OK:
            code = NOT_FINITE
            at_fault = p
    fault[chunk, 0], fault[chunk, 1] = code, at_fault


POWER_CHUNK = 4096  # nodes


@parallel_loop()
def _sum(chunk, force, velocity, sums):
    total = 0.0
    for p in range(POWER_CHUNK * chunk, min(POWER_CHUNK * (chunk + 1), len(force))):
        for d in range(3):
            total += force[p, d] * velocity[p, d]
    sums[chunk, 0] = total


def power(force: np.ndarray, velocity: np.ndarray) -> float:
    """Return the power Σ f·v [W] of forces [N] and velocities [m/s], both of shape (n, 3)."""
    chunks = (len(force) + POWER_CHUNK - 1) // POWER_CHUNK
    sums = np.zeros((chunks, 1))
    _sum(chunks, force, velocity, sums)
    return float(ordered_sum(sums)[0])
