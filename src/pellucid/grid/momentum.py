"""The momentum equation of the nodes with all conditions (`pellucid.grid.nodal_conditions`), and the works of a step.

Most nodes are free and only internal forces and gravity act on them. These nodes are processed by rows, one vector per
node. Forces do work along the mean of the nodal velocities before and after the step. Most nodes are processed directly after
the momentum update, while their data is in the cache. Nodes that await contact impulses are flagged and listed, skipped at
first, and processed after contact.
"""

from typing import Annotated, NamedTuple

import numpy as np

from pellucid.energy import ABSORBED, FIRST_LOAD, FRICTION, GRAVITY, IMPACT, INTERNAL, MOTION, SUPPORT
from pellucid.grid.chunks import listed
from pellucid.grid.lattice import Nodes
from pellucid.grid.nodal_conditions import (
    MASS_EPS,
    ExternalAction,
    Supports,
    apply_friction,
    apply_rule,
    approach,
    find_rule,
    find_support,
    is_beside,
    is_unconstrained,
    is_zero,
)
from pellucid.grid.nodal_fields import FOUND, RUN, NodalField
from pellucid.jit import kernel, pointwise
from pellucid.jit.loops import parallel_for, parallel_loop
from pellucid.jit.memory import numbers
from pellucid.jit.vector import LANES, load, nothing, row, store, total

NOWHERE = np.zeros(0, np.uint8)
"""Empty array, used instead of nodal flags if no node awaits impulses."""


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
def _what_acts(field):
    """Return three flags: True if external forces, absorbing faces or driven points (points with a prescribed motion) act
    on any node of the field (`AdvancedNodes`). Called once for many nodes."""
    return len(field.load) > 0, len(field.external.absorption) > 0, len(field.external.driven_mass) > 0


@pointwise
def _moves_freely(field, acts, I):
    """Return True if node I is unconstrained and only internal forces and gravity act on it; field: see `AdvancedNodes`;
    acts: the three flags returned by `_what_acts`."""
    loaded, absorbing, driven = acts
    free = is_zero(field.nodes.constrained, I)
    if loaded:
        free = free and is_zero(field.load, I)
    if absorbing:
        free = free and is_zero(field.external.absorption, I)
    if driven:
        free = free and is_zero(field.external.driven_mass, I)
    return free


@kernel(inner=True)
def _sum_loads_chunk(chunk, field):
    loads = field.external.loads
    for I in range(field.edges[chunk], field.edges[chunk + 1]):
        for d in range(3):
            external_force = 0.0
            for k in range(len(loads)):
                external_force += loads[k, I, d]
            field.load[I, d] = external_force


@kernel()
def sum_loads(n, field):
    """Sum the external forces of all channels (entries of the energy balance, each with its own array of forces) on the nodes
    of n chunks into `load` [N], if there are any; field: see `AdvancedNodes`."""
    if len(field.load) > 0:
        parallel_for(_sum_loads_chunk, n, field)


@kernel(inner=True)
def _add_separate_forces_chunk(chunk, field):
    """Add the internal forces in `separate_forces` (see `FieldNodes`) to the other internal forces on the nodes of a chunk;
    field: see `AdvancedNodes`."""
    forces, separate = field.nodes.forces, field.separate_forces
    for k in range(4 * field.edges[chunk], 4 * field.edges[chunk + 1], LANES):
        store(forces, k, load(forces, k) + load(separate, k))


@kernel(inner=True)
def _advance_nodes(chunk, field, dt, small, flip):
    nodes, gravity = field.nodes, field.gravity
    external, work, walls = field.external, field.work, field.supports.walls
    mass, momentum, force, velocity = nodes.mass, nodes.momentum, nodes.force, nodes.velocity
    velocity_increment, strain_velocity = nodes.velocity_increment, nodes.strain_velocity
    acts, total_load = _what_acts(field), field.load
    loaded, _, driven = acts
    gravity_increment = row(dt * gravity[0], dt * gravity[1], dt * gravity[2], 0.0)
    of_supports = of_motions = rubbed = 0.0
    yields = len(walls.held) > 0
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
        if _moves_freely(field, acts, I) and not (yields and is_beside(walls, I)):
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
            mapped, external_force = momentum[I, d] * over_m, total_load[I, d] if loaded else 0.0
            gained = dt * (gravity[d] + (force[I, d] + external_force) * over_m)
            s, mirrored = find_support(field, I, d, m, mapped, gained)
            rule = find_rule(field, s, I, d, m, dt)
            old = rule.goal if mirrored else mapped
            without_force = old + dt * gravity[d]
            free = approach(rule.absorbed, -old, without_force + dt * (force[I, d] + external_force) * over_m)
            new = approach(rule.share, rule.goal, free)
            impulse = m * (new - free)
            if s > 0:
                if mirrored:  # FLIP hands on the increment of velocity, PIC the velocity itself
                    impulse += m * (1.0 - flip) * (rule.goal - mapped)
                of_supports += impulse * rule.goal
                work[chunk, first + 3 * (s - 1) + d] += impulse
            elif driven:
                of_motions += impulse * rule.goal
                external.impulse[I, d] = impulse / external.driven_mass[I, d] if rule.share > 0.0 else 0.0
            if yields:
                walls.impulse[I, d] = impulse if s > 0 else 0.0
            velocity_increment[I, d] = new - old
            velocity[I, d] = new
            # f/m of a node that hardly any mass reaches has no bound. Points feel it in proportion to their weight, which
            # bounds it by f over their own mass and keeps momentum; gradients do not, so it must not strain them
            strain_velocity[I, d] = new if m > small else apply_rule(rule, old, without_force)
        if yields:
            rubbed += apply_friction(field, I, m, small, work[chunk], first)
    work[chunk, SUPPORT] = of_supports + rubbed
    work[chunk, MOTION] = of_motions
    work[chunk, FRICTION] = rubbed


@pointwise
def _awaits(awaiting, I):
    return len(awaiting) > 0 and awaiting[I] != 0


@kernel(inner=True)
def _count_works_chunk(chunk, first, chunks, awaiting, field, dt, small):
    nodes, external, gravity, work = field.nodes, field.external, field.gravity, field.work
    mass, force, velocity, velocity_increment = nodes.mass, nodes.force, nodes.velocity, nodes.velocity_increment
    acts, rubbing = _what_acts(field), field.supports.walls.impulse
    loaded, rubs = acts[0], len(rubbing) > 0
    of_rows = numbers(LANES)
    of_velocity, of_mass = row(1.0, 1.0, 1.0, 0.0), row(0.0, 0.0, 0.0, 1.0)
    power, momentum = nothing(of_velocity), nothing(of_velocity)
    internal = gravity_work = sum_of_masses = absorbed = lost = 0.0
    columns = FIRST_LOAD + len(external.loads)
    others = columns + 1 + 3 * len(field.supports.velocity)
    for e in range(chunks.edges[chunk], chunks.edges[chunk + 1]):
        I = listed(chunks.node, e)
        if nodes.has_mass[I] == 0 or _awaits(awaiting, I):
            continue
        m, energy = mass[I], 0.0
        sum_of_masses += m
        if m > small and _moves_freely(field, acts, I):
            change = of_velocity * load(nodes.increments, 4 * I)
            mean_row = load(nodes.velocities, 4 * I) - 0.5 * change
            store(nodes.mean_velocities, 4 * I, mean_row)
            nodes.increment_energy[I] = 0.5 * total(change * change)
            power += load(nodes.forces, 4 * I) * mean_row
            momentum += m * mean_row
            store(nodes.inertia, 4 * I, m * of_mass)
            continue
        for d in range(3):
            s, external_force = nodes.constrained[I, d], field.load[I, d] if loaded else 0.0
            rule = find_rule(field, s, I, d, m, dt)
            if m > small or s > 0:
                increment = velocity_increment[I, d]
                old = velocity[I, d] - increment
                mean = mean_of_gravity = velocity[I, d] - 0.5 * increment
            else:
                increment = dt * gravity[d]
                old = mean = nodes.momentum[I, d] / m
                mean_of_gravity = mean + 0.5 * increment
            energy += 0.5 * increment * increment
            if rule.share > 0.0:
                lost += m * rule.share * (rule.goal - old) * (rule.goal - mean)
                mean = mean_of_gravity = approach(rule.share, rule.goal, mean)
            if rubs and s == 0:
                work[first + chunk, FRICTION] -= rubbing[I, d] * mean
            nodes.mean_velocity[I, d], nodes.momentum[I, d] = mean, 0.0
            internal += dt * force[I, d] * mean
            gravity_work += dt * m * gravity[d] * mean_of_gravity
            if rule.absorbed > 0.0:
                taken = rule.absorbed * (2.0 * m * old + dt * (force[I, d] + external_force + m * gravity[d]))
                absorbed += taken * mean
                work[first + chunk, others + d] -= taken
            if external_force != 0.0:
                work[first + chunk, others + d] += dt * external_force
                for k in range(len(external.loads)):
                    work[first + chunk, FIRST_LOAD + k] += dt * external.loads[k, I, d] * mean
        nodes.increment_energy[I] = energy
    store(of_rows, 0, momentum)
    for d in range(3):
        gravity_work += dt * gravity[d] * of_rows[d]
    work[first + chunk, INTERNAL] = internal + dt * total(power)
    work[first + chunk, GRAVITY] = gravity_work
    work[first + chunk, ABSORBED] = absorbed
    work[first + chunk, IMPACT] = lost
    work[first + chunk, columns] = sum_of_masses


@kernel(inner=True)
def _advance_chunk(chunk, field, dt, small, flip, counted, chunks, awaiting):
    _advance_nodes(chunk, field, dt, small, flip)
    if counted:
        _count_works_chunk(chunk, 0, chunks, awaiting, field, dt, small)


@kernel()
def advance(n, field, dt, small, flip, counted, chunks, awaiting):
    """Advance the momentum p of the nodes in n chunks (`chunks`, see `ChunkedNodes`) over a step dt [s] to p + dt (f + m g),
    with the forces f, the mass m and the acceleration of gravity g, and apply the conditions; if `counted`, also compute the
    works of forces while the data of the nodes is in the cache.

    field: see `AdvancedNodes`; small, flip: `small_mass` and `flip` of `NodalMomentum`; awaiting: flags of the nodes that
    await contact impulses, whose works are not computed yet; `NOWHERE` if there are none.
    """
    if len(field.separate_forces) > 0:
        parallel_for(_add_separate_forces_chunk, n, field)
    sum_loads(n, field)  # by itself: loops over the channels within the momentum equation would slow down all nodes
    parallel_for(_advance_chunk, n, field, dt, small, flip, counted, chunks, awaiting)


@kernel()
def count_works(n, first, chunks, awaiting, field, dt, small):
    """Compute the works of forces in the step dt [s], the heat of conditions and the impulses on the nodes of n chunks
    (`chunks`, see `ChunkedNodes`), a row of `field.work` for each chunk, from row `first` on; see `NodalMomentum.works`. The
    momentum of the nodes is reset to zero, so that momentum can be mapped to the nodes again.

    field: see `AdvancedNodes`; awaiting: flags of nodes to skip, which await contact impulses; `NOWHERE` to skip none; small:
    `small_mass` of `NodalMomentum`.
    """
    parallel_for(_count_works_chunk, n, first, chunks, awaiting, field, dt, small)


@pointwise
def project_node(field, I):
    """Compute `strain_velocity` of node I: the velocity p/m from the momentum p mapped to the node and its mass m, with the
    constraints of the node; along a wall on which the node does not slide, the velocity of the wall.

    field: see `ConditionedNodes`.
    """
    nodes, walls = field.nodes, field.supports.walls
    m = nodes.mass[I]
    over_m = 1.0 / m if m >= MASS_EPS else 0.0
    if is_unconstrained(field, I):
        store(nodes.strain_velocities, 4 * I, over_m * load(nodes.inertia, 4 * I))
        return
    for d in range(3):
        s, v = nodes.constrained[I, d], nodes.momentum[I, d] * over_m
        if s == 0 and len(walls.stuck) > 0:
            s = walls.stuck[I, d]
        nodes.strain_velocity[I, d] = apply_rule(find_rule(field, s, I, d, m, 0.0), v, v)


@kernel(inner=True)
def _meet_walls(chunk, field):
    """Constrain or release the nodes of a chunk at walls that have friction or open, if their momentum has not been advanced
    yet; field: see `AdvancedNodes`."""
    nodes, walls = field.nodes, field.supports.walls
    for I in range(field.edges[chunk], field.edges[chunk + 1]):
        m = nodes.mass[I]
        for d in range(3 if nodes.has_mass[I] == 0 and m >= MASS_EPS else 0):
            walls.stuck[I, d] = 0
            find_support(field, I, d, m, nodes.momentum[I, d] / m, 0.0)


@parallel_loop()
def project(chunk, field, advanced, counted, chunks, awaiting, dt, small, sums):
    """Compute `strain_velocity` (see `project_node`) of those nodes of a chunk that have mass. If `counted`, also compute the
    work of `NodalMomentum.strain_lag_work` for the nodes of the chunk in `chunks` (`ChunkedNodes`), into a row of `sums` [J].

    field: see `AdvancedNodes`; advanced: True if the momentum has been advanced with the present nodal masses; dt: step
    [s]; awaiting: flags of nodes to skip in the work, which await contact impulses; small: `small_mass` of `NodalMomentum`.
    """
    nodes = field.nodes
    if not advanced and len(field.supports.walls.held) > 0:
        _meet_walls(chunk, field)
    for I in range(field.edges[chunk], field.edges[chunk + 1]):
        if nodes.has_mass[I] or (not advanced and nodes.mass[I] >= MASS_EPS):
            project_node(field, I)
    if counted:
        _sum_strain_lag_chunk(chunk, 0, chunks, awaiting, field, dt, small, sums)


@kernel(inner=True)
def _sum_strain_lag_chunk(chunk, first, chunks, awaiting, field, dt, small, sums):
    nodes, work, several = field.nodes, 0.0, len(field.separate_forces) > 0
    power = row(0.0, 0.0, 0.0, 0.0)
    for e in range(chunks.edges[chunk], chunks.edges[chunk + 1]):
        I = listed(chunks.node, e)
        if nodes.has_mass[I] == 0 or _awaits(awaiting, I):
            continue
        m = nodes.mass[I]
        if m > small and is_unconstrained(field, I):
            force_row = load(nodes.forces, 4 * I)
            if several:
                force_row -= load(field.separate_forces, 4 * I)
            power += force_row * (load(nodes.velocities, 4 * I) - load(nodes.strain_velocities, 4 * I))
            continue
        for d in range(3):
            force = nodes.force[I, d] - field.separate_forces[4 * I + d] if several else nodes.force[I, d]
            old = mean = nodes.mean_velocity[I, d]
            s = nodes.constrained[I, d]
            if m > small or s > 0:
                old = nodes.velocity[I, d] - nodes.velocity_increment[I, d]
            if s == 0:  # as points were strained along it
                old = apply_rule(find_rule(field, s, I, d, m, 0.0), old, old)
            work += 0.5 * dt * force * (2.0 * mean - old - nodes.strain_velocity[I, d])
    sums[first + chunk, 0] = work + 0.5 * dt * total(power)


@kernel()
def sum_strain_lag(n, first, chunks, awaiting, field, dt, small, sums):
    """Compute the work returned by `NodalMomentum.strain_lag_work` in a step dt [s] for n chunks of nodes (`chunks`, see
    `ChunkedNodes`), into rows of `sums` [J] from row `first` on.

    field: see `AdvancedNodes`; awaiting: flags of nodes to skip, which await contact impulses; `NOWHERE` to skip none; small:
    `small_mass` of `NodalMomentum`.
    """
    parallel_for(_sum_strain_lag_chunk, n, first, chunks, awaiting, field, dt, small, sums)
