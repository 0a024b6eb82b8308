"""The momentum equation of the nodes, with external actions and constraints.

Most nodes are free and only internal forces and gravity act on them. These nodes are processed by rows, one vector per
node.
"""

from typing import Annotated, NamedTuple

import numpy as np

from pellucid.energy import FIRST_LOAD, FRICTION, IMPACT, SUPPORT
from pellucid.grid.lattice import Nodes
from pellucid.grid.nodal_fields import FOUND, RUN, STEP, SUM, NodalField
from pellucid.grid.supports import Supports, is_beside, leaves, rub
from pellucid.jit import kernel, pointwise
from pellucid.jit.vector import LANES, load, nothing, row, store

FULL_DRIVE_FRACTION = 0.05  # fraction of a node's mass from driven points, from which on the node fully follows their motion
MASS_EPS = 1e-290  # nodes with a smaller mass [kg] count as nodes without mass


class ExternalAction(NamedTuple):
    """External actions on nodes, in addition to gravity and supports; arrays of absent actions have no rows.

    Conditions request the arrays, see `pellucid.grid.actions`.

    A prescribed motion constrains the nodes that its driven points (the points that it moves) reach. The constraint is
    complete if the driven points contribute at least the share FULL_DRIVE_FRACTION of the mass of the node; below, it is
    proportional to the share. If the constraint were complete as soon as the shape function of a driven point reaches a
    node, a body would cause an impulse at every cell that it crosses. If it were proportional throughout, the node would
    yield to a lasting force.
    """

    loads: Annotated[np.ndarray, NodalField(3, SUM, STEP, "N", "external forces, an array for each channel", several=True)]
    absorption: Annotated[np.ndarray, NodalField(3, FOUND, RUN, "1/s", "rate at which an absorbing face removes momentum")]
    absorbed: Annotated[np.ndarray, NodalField(3, FOUND, RUN, "N s", "impulse of absorbing faces over the step")]
    driven_mass: Annotated[np.ndarray, NodalField(3, SUM, STEP, "kg", "mass of driven points")]
    driven_momentum: Annotated[
        np.ndarray, NodalField(3, SUM, STEP, "kg m/s", "momentum of driven points at the prescribed velocity")
    ]
    impulse: Annotated[np.ndarray, NodalField(3, FOUND, RUN, "m/s", "impulse of prescribed motions per unit driven mass")]
    drag_momentum: Annotated[np.ndarray, NodalField(3, SUM, STEP, "kg m/s", "momentum removed by drags before the step")]


class AdvancedNodes(NamedTuple):
    """Nodes of a velocity field, the actions on them and their constraints, as arguments of kernels."""

    nodes: Nodes  # mass, momentum, forces and velocities
    supports: Supports  # constraints
    gravity: np.ndarray  # (3,) present gravity [m/s²]
    external: ExternalAction  # actions of conditions
    load: Annotated[np.ndarray, NodalField(3, FOUND, RUN, "N", "sum of the external forces, if there are any")]
    separate_forces: np.ndarray  # see `FieldNodes`
    work: np.ndarray  # (rows, ...) works in the layout of `pellucid.energy`, a row for each chunk
    edges: np.ndarray  # first node of each chunk of nodes, and the end of the last, see `pellucid.grid.chunks`


@pointwise
def driven_fraction(external, I, d, m):
    """Return the fraction, 0 to 1, to which the prescribed velocity of driven points (points with a prescribed motion)
    determines the velocity of node I of mass m [kg] along axis d; external: see `ExternalAction`."""
    return min(1.0, external.driven_mass[I, d] / (FULL_DRIVE_FRACTION * m))


@pointwise
def driven_velocity(external, I, d):
    """Return the mean prescribed velocity along axis d of the driven points (points with a prescribed motion) that
    contribute to node I [m/s]; external: see `ExternalAction`."""
    return external.driven_momentum[I, d] / external.driven_mass[I, d]


@pointwise
def is_driven(external, I, d):
    """Return True if driven points (points with a prescribed motion) constrain the velocity of node I along axis d, completely
    or partly; external: see `ExternalAction`."""
    return len(external.driven_mass) > 0 and external.driven_mass[I, d] > 0.0


@pointwise
def apply_prescribed_velocity(external, I, d, m, v):
    """Return the velocity of node I of mass m [kg] along axis d [m/s]: v, corrected by the prescribed velocity of driven
    points (points with a prescribed motion) that contribute to the node; external: see `ExternalAction`."""
    if is_driven(external, I, d) and m >= MASS_EPS:
        v += driven_fraction(external, I, d, m) * (driven_velocity(external, I, d) - v)
    return v


@pointwise
def apply_absorption(external, I, d, dt, old, new):
    """Return the velocity [m/s] of node I along axis d after a step dt [s] in which an absorbing face reduces the velocity.
    Absorption acts on the mean velocity over the step, which is stable for any time step.

    external: see `ExternalAction`; old: velocity before the step; new: velocity after the step without absorption [m/s].
    """
    half = 0.5 * dt * external.absorption[I, d]
    return (new - half * old) / (1.0 + half)


@pointwise
def is_zero(vectors, I):
    """Return True if the vector of node I is zero; vectors: shape (nodes, 3)."""
    return vectors[I, 0] == 0 and vectors[I, 1] == 0 and vectors[I, 2] == 0


@pointwise
def is_unconstrained(nodes, external, I):
    """Return True if neither supports nor driven points (points with a prescribed motion) constrain node I along any axis;
    arguments: see `AdvancedNodes`."""
    return is_zero(nodes.constrained, I) and (len(external.driven_mass) == 0 or is_zero(external.driven_mass, I))


@pointwise
def what_acts(field):
    """Return three flags: True if external forces, absorbing faces or driven points (points with a prescribed motion) act
    on any node of the field (`AdvancedNodes`). Called once for many nodes."""
    return len(field.load) > 0, len(field.external.absorption) > 0, len(field.external.driven_mass) > 0


@pointwise
def moves_freely(field, acts, I):
    """Return True if node I is unconstrained and only internal forces and gravity act on it; field: see `AdvancedNodes`;
    acts: the three flags returned by `what_acts`."""
    loaded, absorbing, driven = acts
    free = is_zero(field.nodes.constrained, I)
    if loaded:
        free = free and is_zero(field.load, I)
    if absorbing:
        free = free and is_zero(field.external.absorption, I)
    if driven:
        free = free and is_zero(field.external.driven_mass, I)
    return free


@pointwise
def meet_wall(field, I, d, m, v, gained):
    """Constrain node I along axis d at a wall that has friction or opens (releases bodies that move away), or release the
    node if the wall opens and the node moves away. Return 1 + the number of the support that acts as the wall (0:
    released), which is also stored in `constrained`, and whether the wall acts as a plane of symmetry for the body.

    field: see `AdvancedNodes`; m: mass [kg]; v, gained: velocity before the step, and its change by forces [m/s]. A wall
    that opens acts as a plane of symmetry only if it constrained the node before and forces do not pull the node away:
    otherwise the mirror image of the body would pull the node.
    """
    nodes, walls = field.nodes, field.supports.walls
    s, was_held = walls.held[I, d], nodes.constrained[I, d] != 0
    if leaves(field.supports, s, I, d, apply_prescribed_velocity(field.external, I, d, m, v + gained)):
        nodes.constrained[I, d] = 0
        return 0, False
    nodes.constrained[I, d] = s
    return s, walls.opens[s - 1] == 0 or (was_held and walls.inward[s - 1] * gained <= 0.0)


@pointwise
def may_slide(field, I, d):
    """Return True if neither a support nor driven points (points with a prescribed motion) constrain the velocity of node I
    along axis d; field: see `AdvancedNodes`."""
    return field.nodes.constrained[I, d] == 0 and not is_driven(field.external, I, d)


@kernel(inner=True)
def advance_chunk(chunk, field, dt, small, flip):
    """Advance the momentum p of the nodes of a chunk over a step dt [s] to p + dt (f + m g), with the forces f, the mass m
    and the acceleration of gravity g, and apply supports and prescribed motions.

    field: see `AdvancedNodes`; small, flip: `small_mass` and `flip` of `NodalMomentum`.
    """
    nodes, walls, mirror, gravity = field.nodes, field.supports.velocity, field.supports.mirror, field.gravity
    external, work = field.external, field.work
    mass, momentum, force, velocity = nodes.mass, nodes.momentum, nodes.force, nodes.velocity
    velocity_increment, strain_velocity, constrained = nodes.velocity_increment, nodes.strain_velocity, nodes.constrained
    acts, total_load = what_acts(field), field.load
    loaded, absorbing, driven = acts
    gravity_increment = row(dt * gravity[0], dt * gravity[1], dt * gravity[2], 0.0)
    pushed = lost = rubbed = 0.0
    yields = len(field.supports.walls.held) > 0
    first = FIRST_LOAD + len(external.loads) + 1  # of the impulses
    for I in range(field.edges[chunk], field.edges[chunk + 1]):
        m = mass[I]
        if m < MASS_EPS:
            if nodes.has_mass[I]:
                nodes.has_mass[I] = 0
                zero = nothing(gravity_increment)
                store(nodes.velocities, 4 * I, zero)
                store(nodes.increments, 4 * I, zero)
                store(nodes.strain_velocities, 4 * I, zero)
                store(nodes.mean_velocities, 4 * I, zero)
            continue
        nodes.has_mass[I], over_m = 1, 1.0 / m
        if moves_freely(field, acts, I) and not (yields and is_beside(field.supports.walls, I)):
            if driven:
                external.impulse[I, 0] = external.impulse[I, 1] = external.impulse[I, 2] = 0.0
            before = over_m * load(nodes.inertia, 4 * I)
            with_gravity = before + gravity_increment
            after = with_gravity + (dt * over_m) * load(nodes.forces, 4 * I)
            store(nodes.velocities, 4 * I, after)
            store(nodes.increments, 4 * I, after - before)
            if m > small:
                store(nodes.strain_velocities, 4 * I, after)
            else:
                store(nodes.strain_velocities, 4 * I, with_gravity)
            continue
        for d in range(3):
            mapped = momentum[I, d] * over_m
            external_force = total_load[I, d] if loaded else 0.0
            s = constrained[I, d]
            mirrored = s > 0 and mirror[s - 1] != 0
            if yields and field.supports.walls.held[I, d] > 0:
                gained = dt * (gravity[d] + (force[I, d] + external_force) * over_m)
                s, mirrored = meet_wall(field, I, d, m, mapped, gained)
            # a wall's nodes have its velocity before the step too: then points beside a wall keep their velocity, as they do
            # beside their mirror image; points in a clamp take the velocity of the clamp
            v = walls[s - 1, d] if mirrored else mapped
            velocity_without_force = v + dt * gravity[d]
            new = velocity_without_force + dt * (force[I, d] + external_force) * over_m
            if absorbing and s == 0:
                freely, new = new, apply_absorption(external, I, d, dt, v, new)
                velocity_without_force = apply_absorption(external, I, d, dt, v, velocity_without_force)
                external.absorbed[I, d] = m * (new - freely)
            if driven and s == 0:
                external.impulse[I, d] = 0.0
                if is_driven(external, I, d):
                    freely, new = new, apply_prescribed_velocity(external, I, d, m, new)
                    velocity_without_force = apply_prescribed_velocity(external, I, d, m, velocity_without_force)
                    external.impulse[I, d] = m * (new - freely) / external.driven_mass[I, d]
            if s > 0:
                wall = walls[s - 1, d]
                impulse = m * (wall - new)
                lost += 0.5 * m * (wall - v) * (wall - v)
                if mirrored:  # FLIP hands on the increment of velocity, PIC the velocity itself
                    impulse += m * (1.0 - flip) * (wall - mapped)
                pushed += impulse * wall
                work[chunk, first + 3 * (s - 1) + d] += impulse
                if yields:
                    field.supports.walls.impulse[I, d] = impulse
                new = wall
            elif yields:
                field.supports.walls.impulse[I, d] = 0.0
            velocity_increment[I, d] = new - v
            velocity[I, d] = new
            # f/m of a node that hardly any mass reaches has no bound. Points feel it in proportion to their weight, which
            # bounds it by f over their own mass and keeps momentum; gradients do not, so it must not strain them
            strain_velocity[I, d] = new if m > small or s > 0 else velocity_without_force
        if yields:
            slides = may_slide(field, I, 0), may_slide(field, I, 1), may_slide(field, I, 2)
            rubbed += rub(nodes, field.supports, slides, I, m, small, work[chunk], first)
    work[chunk, SUPPORT] = pushed + rubbed
    work[chunk, IMPACT] = lost
    work[chunk, FRICTION] = rubbed


@kernel(inner=True)
def sum_loads_chunk(chunk, field):
    """Sum the external forces of all channels (entries of the energy balance, each with its own array of forces) on the nodes
    of a chunk into `load` [N]; field: see `AdvancedNodes`."""
    loads = field.external.loads
    for I in range(field.edges[chunk], field.edges[chunk + 1]):
        for d in range(3):
            external_force = 0.0
            for k in range(len(loads)):
                external_force += loads[k, I, d]
            field.load[I, d] = external_force


@kernel(inner=True)
def add_separate_forces_chunk(chunk, field):
    """Add the internal forces in `separate_forces` (see `FieldNodes`) to the other internal forces on the nodes of a chunk;
    field: see `AdvancedNodes`."""
    forces, separate = field.nodes.forces, field.separate_forces
    for k in range(4 * field.edges[chunk], 4 * field.edges[chunk + 1], LANES):
        store(forces, k, load(forces, k) + load(separate, k))
