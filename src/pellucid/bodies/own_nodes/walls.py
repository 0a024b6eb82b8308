"""Kernels for nodes at walls of the grid, with friction.

A node that would pass a wall is stopped at the wall by an impulse P. Friction then reduces its motion along the wall, by an
impulse of at most μ P (see `pellucid.grid.nodal_conditions`).
"""

from math import sqrt

from pellucid.energy import FIRST_LOAD, FRICTION, SUPPORT
from pellucid.jit import pointwise

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
