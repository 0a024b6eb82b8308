"""Constraints of grid nodes: supports, and walls that have friction or release bodies.

A wall is a face of the grid that a support constrains along its normal. Let P be the impulse with which the wall stops a
node of mass m in a step. Coulomb friction with the coefficient μ is an impulse J along the wall that opposes the sliding of
the node and is at most μ P:

    J = -m u min(1, μ P / m|u|),

where u is the velocity of the node relative to the wall, along the wall, with all other impulses. A wall that opens
releases a node whose velocity, including all forces, points away from the wall.
"""

from math import sqrt
from typing import Annotated, NamedTuple

import numpy as np

from pellucid.grid.nodal_fields import FOUND, MIN, RUN, STEP, NodalField
from pellucid.jit import pointwise


class YieldingWalls(NamedTuple):
    """Walls that have friction or open (release a body that moves away); without such walls the arrays have no rows. The states
    of nodes keep their values until the next step."""

    friction: np.ndarray  # (supports,) coefficient; 0 without friction, infinite if nodes cannot slide
    opens: np.ndarray  # (supports,) 1 if the wall releases nodes that move away
    inward: np.ndarray  # (supports,) 1 or -1, the direction from the wall into the grid along its axis
    held: Annotated[
        np.ndarray,
        NodalField(
            3,
            FOUND,
            RUN,
            "",
            "like `constrained`, for yielding walls only, including walls that have released the node",
            np.int16,
        ),
    ]
    stuck: Annotated[
        np.ndarray,
        NodalField(3, FOUND, RUN, "", "0, or 1 + the number of the support or face on which the node does not slide", np.int16),
    ]
    gap: Annotated[np.ndarray, NodalField(3, MIN, STEP, "m", "distance of bodies from walls that open")]
    impulse: Annotated[np.ndarray, NodalField(3, FOUND, RUN, "N s", "impulse of walls over the step; tangentially: friction")]


def no_walls() -> YieldingWalls:
    """Return the arrays, without rows, of a velocity field in which no wall has friction or opens (releases bodies that
    move away)."""
    none, marks, vectors = np.zeros(0), np.zeros((0, 3), np.int16), np.zeros((0, 3))
    return YieldingWalls(none, np.zeros(0, np.uint8), none, marks, marks, vectors, vectors)


class Supports(NamedTuple):
    """Constraints of nodes by supports: velocity and kind, one row for each support. `Nodes.constrained` contains 1 + the
    number of a row, or 0."""

    velocity: np.ndarray  # (supports, 3) prescribed velocity [m/s]
    mirror: np.ndarray  # (supports,) 1 for a wall, at which a body is mirrored; 0 for a clamp within a body
    walls: YieldingWalls = no_walls()  # walls that have friction or open


@pointwise
def is_beside(walls, I):
    """Return True if a wall with friction, or a wall that opens (releases bodies that move away), constrains node I or may
    constrain it again; walls: see `YieldingWalls`."""
    return walls.held[I, 0] > 0 or walls.held[I, 1] > 0 or walls.held[I, 2] > 0


@pointwise
def leaves(supports, s, I, d, v):
    """Return True if support s, counted from 1, is a wall that opens (releases bodies that move away) and releases node I:
    there is a gap between the bodies and the wall, or the velocity v of the node along its axis d [m/s], relative to the
    wall, points away from it.

    supports: `Supports`.
    """
    walls = supports.walls
    if walls.opens[s - 1] == 0:
        return False
    return walls.gap[I, d] > 0.0 or walls.inward[s - 1] * (v - supports.velocity[s - 1, d]) > 0.0


@pointwise
def meet_walls(nodes, supports, I):
    """Before the first step in which node I has mass, constrain the node at walls that have friction or open (release
    bodies that move away), or release the node, if `leaves` returns True for the velocity of the momentum mapped from
    points; nodes: nodal arrays; supports: `Supports`."""
    walls = supports.walls
    for d in range(3):
        walls.stuck[I, d], s = 0, walls.held[I, d]
        if s > 0:
            nodes.constrained[I, d] = 0 if leaves(supports, s, I, d, nodes.momentum[I, d] / nodes.mass[I]) else s


@pointwise
def rub(nodes, supports, slides, I, m, small, work, first):
    """Apply the friction of the walls in contact with node I of mass m [kg], after the momentum update; return the work of the
    walls [J].

    nodes: nodal arrays; slides: True for each axis along which the node may slide; small: see `NodalMomentum`; work: a row
    of works, with the impulses of supports from column `first` on. `YieldingWalls.impulse` contains the normal impulses of
    walls.
    """
    walls, done = supports.walls, 0.0
    for d in range(3):
        walls.stuck[I, d] = 0
    for axis in range(3):
        s = nodes.constrained[I, axis]
        if s == 0 or s != walls.held[I, axis]:
            continue
        most = walls.friction[s - 1] * (walls.inward[s - 1] * walls.impulse[I, axis])
        if not most > 0.0:
            continue
        square = 0.0
        for d in range(3):
            if slides[d]:
                square += (nodes.velocity[I, d] - supports.velocity[s - 1, d]) ** 2
        whole = m * sqrt(square)
        for d in range(3):
            if not slides[d]:
                continue
            wall, old = supports.velocity[s - 1, d], nodes.velocity[I, d]
            new = wall if whole <= most else old + (most / whole) * (wall - old)
            if whole <= most:
                walls.stuck[I, d] = s
            nodes.velocity[I, d] = new
            nodes.velocity_increment[I, d] += new - old
            if m > small or whole <= most:
                nodes.strain_velocity[I, d] = new
            impulse = m * (new - old)
            walls.impulse[I, d] += impulse
            work[first + 3 * (s - 1) + d] += impulse
            done += impulse * wall
    return done
