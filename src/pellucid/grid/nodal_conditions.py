"""Conditions on the velocities of nodes: each acts along an axis by one rule, in one fixed order.

A condition with the share φ, 0 to 1, and the velocity `goal` changes the velocity v of a node of mass m, and thus exerts the
impulse J:

    v ← v + φ (goal - v) ,    J = m φ (goal - v) .

| condition                            | φ                                  | goal                              |
|--------------------------------------|------------------------------------|-----------------------------------|
| 1. support: wall, clamp, thin axis   | 1                                  | velocity of the support           |
| 2. absorbing face                    | h/(1 + h), h = rate Δt/2           | minus the velocity before the step|
| 3. driven points                     | min(1, share of mass / FULL_DRIVE_FRACTION) | their mean prescribed velocity |
| 4. friction of a wall                | min(1, μP/m|u|)                    | velocity of the wall              |

Precedence: where a support constrains an axis of a node, nothing else acts along this axis. Else the absorbing face acts
first and the driven points next; friction acts last, and only along axes without driven points. Further impulses (contact,
conditions) act only where the share of the third is less than 1, see `free_axes`.

Absorption acts on the mean velocity over the step, which is stable for any time step. A prescribed motion constrains the
nodes that its driven points (the points that it moves) reach: completely if these contribute at least the share
FULL_DRIVE_FRACTION of the mass of the node, else in proportion. If the constraint were complete as soon as the shape function
of a driven point reaches a node, a body would cause an impulse at every cell that it crosses. If it were proportional
throughout, the node would yield to a lasting force.

A wall is a face of the grid that a support constrains along its normal. It acts as a plane of symmetry: its nodes have the
velocity of the wall before the step too, so that points beside it keep their velocity, as they do beside their mirror image;
points in a clamp take the velocity of the clamp. A wall that opens releases a node whose velocity, with all forces, points
away from the wall. If P is the impulse with which the wall stops a node, Coulomb friction with the coefficient μ is at most
μP and opposes the velocity u of the node along the wall, relative to the wall.

Work and heat follow from φ and goal too. Let v° be the velocity of the node before the step and v̄ the mean of the velocities
before and after it. Supports, driven points and walls do the work J·goal. Other forces work along v̄ + φ (goal - v̄), and the
impact of arriving mass, m φ (goal - v°)·(goal - v̄), is heat, as is the work of friction -J·v̄ + J·goal. An absorbing face
removes -J·v̄.
"""

from math import sqrt
from typing import Annotated, Any, NamedTuple

import numpy as np

from pellucid.grid.lattice import Nodes
from pellucid.grid.nodal_fields import FOUND, MIN, RUN, STEP, SUM, NodalField
from pellucid.jit import pointwise

FULL_DRIVE_FRACTION = 0.05  # fraction of a node's mass from driven points, from which on the node fully follows their motion
MASS_EPS = 1e-290  # nodes with a smaller mass [kg] count as nodes without mass


class ExternalAction(NamedTuple):
    """External actions on nodes, in addition to gravity and supports; arrays of absent actions have no rows.

    Conditions request the arrays, see `pellucid.grid.actions`.
    """

    loads: Annotated[np.ndarray, NodalField(3, SUM, STEP, "N", "external forces, an array for each channel", several=True)]
    absorption: Annotated[np.ndarray, NodalField(3, FOUND, RUN, "1/s", "rate at which an absorbing face removes momentum")]
    driven_mass: Annotated[np.ndarray, NodalField(3, SUM, STEP, "kg", "mass of driven points")]
    driven_momentum: Annotated[
        np.ndarray, NodalField(3, SUM, STEP, "kg m/s", "momentum of driven points at the prescribed velocity")
    ]
    impulse: Annotated[np.ndarray, NodalField(3, FOUND, RUN, "m/s", "impulse of prescribed motions per unit driven mass")]
    drag_momentum: Annotated[np.ndarray, NodalField(3, SUM, STEP, "kg m/s", "momentum removed by drags before the step")]


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


class ConditionedNodes(NamedTuple):
    """Nodes of a velocity field and the conditions on them. The functions below take such a set, or a set with more members, as
    their argument `field`."""

    nodes: Nodes  # mass, momentum and velocities
    supports: Supports  # constraints
    external: ExternalAction  # actions of conditions, such as prescribed motions


class Rule(NamedTuple):
    """Conditions on a node along one axis, except friction: shares φ and goal of the rule v ← v + φ (goal - v)."""

    absorbed: Any  # φ of an absorbing face, 0 if there is none
    share: Any  # φ of a support or of driven points, 0 without both
    goal: Any  # velocity that these prescribe [m/s]


@pointwise
def is_driven(external, I, d, m):
    """Return True if driven points (points with a prescribed motion) contribute to node I of mass m [kg] and thus constrain it
    along axis d, completely or partly, if no support does; external: see `ExternalAction`."""
    return len(external.driven_mass) > 0 and external.driven_mass[I, d] > 0.0 and m >= MASS_EPS


@pointwise
def find_rule(field, s, I, d, m, dt):
    """Return the conditions on node I of mass m [kg] along axis d, a `Rule`.

    field: see `ConditionedNodes`; s: 1 + the number of the support that constrains the node along the axis, else 0; dt: step
    [s] over which an absorbing face acts, 0 to leave it out.
    """
    external, absorbed, share, goal = field.external, 0.0, 0.0, 0.0
    if s > 0:
        return Rule(absorbed, 1.0, field.supports.velocity[s - 1, d])
    if len(external.absorption) > 0:
        half = 0.5 * dt * external.absorption[I, d]
        absorbed = half / (1.0 + half)
    if is_driven(external, I, d, m):
        share = min(1.0, external.driven_mass[I, d] / (FULL_DRIVE_FRACTION * m))
        goal = external.driven_momentum[I, d] / external.driven_mass[I, d]
    return Rule(absorbed, share, goal)


@pointwise
def approach(share, goal, v):
    """Return the velocity v + φ (goal - v) [m/s] with the share φ; exactly `goal` if φ is 1."""
    return goal if share == 1.0 else v + share * (goal - v)


@pointwise
def apply_rule(rule, before, v):
    """Return the velocity of a node along an axis [m/s] to which its conditions, a `Rule`, change the velocity v; before:
    velocity before the step."""
    return approach(rule.share, rule.goal, approach(rule.absorbed, -before, v))


@pointwise
def is_zero(vectors, I):
    """Return True if the vector of node I is zero; vectors: shape (nodes, 3)."""
    return vectors[I, 0] == 0 and vectors[I, 1] == 0 and vectors[I, 2] == 0


@pointwise
def is_unconstrained(field, I):
    """Return True if neither supports nor driven points (points with a prescribed motion) constrain node I along any axis;
    field: see `ConditionedNodes`."""
    driven = field.external.driven_mass
    return is_zero(field.nodes.constrained, I) and (len(driven) == 0 or is_zero(driven, I))


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
def find_support(field, I, d, m, v, gained):
    """Find the support that constrains node I of mass m [kg] along axis d in a step; a wall that opens may release the node
    or hold it again, which is stored in `constrained`. Return 1 + its number, 0 if there is none, and whether it acts as a
    plane of symmetry.

    field: see `ConditionedNodes`; v, gained: velocity before the step, and its change by forces [m/s]. A wall that opens
    acts as a plane of symmetry only if it constrained the node before and forces do not pull the node away: otherwise the
    mirror image of the body would pull the node.
    """
    nodes, supports = field.nodes, field.supports
    walls, s = supports.walls, nodes.constrained[I, d]
    if len(walls.held) == 0 or walls.held[I, d] == 0:
        return s, s > 0 and supports.mirror[s - 1] != 0
    was_held, s = s != 0, walls.held[I, d]
    if leaves(supports, s, I, d, apply_rule(find_rule(field, 0, I, d, m, 0.0), v, v + gained)):
        nodes.constrained[I, d] = 0
        return 0, False
    nodes.constrained[I, d] = s
    return s, walls.opens[s - 1] == 0 or (was_held and walls.inward[s - 1] * gained <= 0.0)


@pointwise
def may_slide(field, I, d, m):
    """Return True if neither a support nor driven points (points with a prescribed motion) constrain the velocity of node I
    of mass m [kg] along axis d; field: see `ConditionedNodes`."""
    return field.nodes.constrained[I, d] == 0 and not is_driven(field.external, I, d, m)


@pointwise
def apply_friction(field, I, m, small, work, first):
    """Apply the friction of the walls in contact with node I of mass m [kg], after all other conditions; return the work of the
    walls [J].

    field: see `ConditionedNodes`; small: see `NodalMomentum`; work: a row of works, with the impulses of supports from column
    `first` on. `YieldingWalls.impulse` contains the normal impulses of walls.
    """
    nodes, supports, walls, done = field.nodes, field.supports, field.supports.walls, 0.0
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
            if may_slide(field, I, d, m):
                square += (nodes.velocity[I, d] - supports.velocity[s - 1, d]) ** 2
        whole = m * sqrt(square)
        share = 1.0 if whole <= most else most / whole
        for d in range(3):
            if not may_slide(field, I, d, m):
                continue
            goal, old = supports.velocity[s - 1, d], nodes.velocity[I, d]
            new = approach(share, goal, old)
            if share == 1.0:
                walls.stuck[I, d] = s
            nodes.velocity[I, d] = new
            nodes.velocity_increment[I, d] += new - old
            if m > small or share == 1.0:
                nodes.strain_velocity[I, d] = new
            impulse = m * (new - old)
            walls.impulse[I, d] += impulse
            work[first + 3 * (s - 1) + d] += impulse
            done += impulse * goal
    return done


def free_axes(nodes: Nodes, external: ExternalAction, node: np.ndarray | slice = slice(None)) -> np.ndarray:
    """Return a mask, shape (n, 3), of the axes along which impulses can change the velocities of nodes: the nodes have mass,
    and neither a support nor driven points (points with a prescribed motion) determine their velocities completely.

    nodes, external: nodal arrays and actions, see `ConditionedNodes`; node: indices of the nodes; default: all nodes.
    """
    mass = nodes.mass[node, None]
    free = (mass >= MASS_EPS) & (nodes.constrained[node] == 0)
    if len(external.driven_mass):
        free &= external.driven_mass[node] < FULL_DRIVE_FRACTION * mass
    return np.asarray(free)
