"""Works of forces on the nodes in a step, along the mean of the nodal velocities before and after it.

Most nodes are processed directly after the momentum update, while their data is in the cache. Nodes that await contact
impulses are flagged and listed, skipped at first, and processed after contact.
"""

import numpy as np

from pellucid.energy import ABSORBED, FIRST_LOAD, FRICTION, GRAVITY, IMPACT, INTERNAL, MOTION
from pellucid.grid.listed import listed
from pellucid.grid.momentum import (
    apply_prescribed_velocity,
    driven_fraction,
    driven_velocity,
    is_driven,
    is_unconstrained,
    moves_freely,
    what_acts,
)
from pellucid.jit import kernel, pointwise
from pellucid.jit.memory import numbers
from pellucid.jit.vector import LANES, load, nothing, row, store, total

NOWHERE = np.zeros(0, np.uint8)
"""Empty array, used instead of nodal flags if no node awaits impulses."""


@pointwise
def _awaits(awaiting, I):
    return len(awaiting) > 0 and awaiting[I] != 0


@kernel(inner=True)
def count_works_chunk(chunk, first, chunks, awaiting, field, dt, small):
    """Compute the works of forces on the nodes of a chunk in a step dt [s], and the impulses on them, in row `first +
    chunk` of `field.work`, see `NodalMomentum.works`. Nodes that await contact impulses are skipped. The momentum of the
    nodes is reset to zero, so that momentum can be mapped to the nodes again.

    first: row of `field.work` for chunk 0; all other arguments: see `pellucid.grid.nodal_passes.count_works`.
    """
    nodes, external, gravity, work = field.nodes, field.external, field.gravity, field.work
    mass, force, velocity, velocity_increment = nodes.mass, nodes.force, nodes.velocity, nodes.velocity_increment
    acts, rubbing = what_acts(field), field.supports.walls.impulse
    loaded, absorbing, rubs = acts[0], acts[1], len(rubbing) > 0
    of_rows = numbers(LANES)
    of_velocity, of_mass = row(1.0, 1.0, 1.0, 0.0), row(0.0, 0.0, 0.0, 1.0)
    power, momentum = nothing(of_velocity), nothing(of_velocity)
    internal = gravity_work = sum_of_masses = absorbed = moved = lost = 0.0
    columns = FIRST_LOAD + len(external.loads)
    others = columns + 1 + 3 * len(field.supports.velocity)
    for e in range(chunks.edges[chunk], chunks.edges[chunk + 1]):
        I = listed(chunks.node, e)
        if nodes.has_mass[I] == 0 or _awaits(awaiting, I):
            continue
        m, energy = mass[I], 0.0
        sum_of_masses += m
        if m > small and moves_freely(field, acts, I):
            change = of_velocity * load(nodes.increments, 4 * I)
            mean_row = load(nodes.velocities, 4 * I) - 0.5 * change
            store(nodes.mean_velocities, 4 * I, mean_row)
            nodes.increment_energy[I] = 0.5 * total(change * change)
            power += load(nodes.forces, 4 * I) * mean_row
            momentum += m * mean_row
            store(nodes.inertia, 4 * I, m * of_mass)
            continue
        for d in range(3):
            increment, s = velocity_increment[I, d], nodes.constrained[I, d]
            heavy = m > small or s > 0
            external_force = field.load[I, d] if loaded else 0.0
            if heavy:
                mean = mean_of_gravity = velocity[I, d] - 0.5 * increment
                energy += 0.5 * increment * increment
            else:
                mean, pull = nodes.momentum[I, d] / m, dt * gravity[d]
                mean_of_gravity = mean + 0.5 * pull
                energy += 0.5 * pull * pull
            if s > 0:
                mean = mean_of_gravity = field.supports.velocity[s - 1, d]
            elif is_driven(external, I, d):
                given, goal = external.impulse[I, d] * external.driven_mass[I, d], driven_velocity(external, I, d)
                follow = driven_fraction(external, I, d, m)
                other = dt * (force[I, d] + m * gravity[d] + external_force)
                moved += given * goal
                lost += (given + follow * other) * (goal - mean)
                mean += follow * (goal - mean)
                mean_of_gravity = mean
            if rubs and s == 0:
                work[first + chunk, FRICTION] -= rubbing[I, d] * mean
            nodes.mean_velocity[I, d], nodes.momentum[I, d] = mean, 0.0
            internal += dt * force[I, d] * mean
            gravity_work += dt * m * gravity[d] * mean_of_gravity
            if absorbing and external.absorbed[I, d] != 0.0:
                absorbed -= external.absorbed[I, d] * mean
                work[first + chunk, others + d] += external.absorbed[I, d]
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
    work[first + chunk, MOTION] = moved
    work[first + chunk, IMPACT] += lost
    work[first + chunk, columns] = sum_of_masses


@kernel(inner=True)
def sum_strain_lag_chunk(chunk, first, chunks, awaiting, field, dt, small, sums):
    """Compute the work returned by `NodalMomentum.strain_lag_work` in a step dt [s] for a chunk of nodes, into row `first +
    chunk` of `sums` [J]. All other arguments: see `pellucid.grid.nodal_passes.sum_strain_lag`."""
    nodes, external, work, several = field.nodes, field.external, 0.0, len(field.separate_forces) > 0
    power = row(0.0, 0.0, 0.0, 0.0)
    for e in range(chunks.edges[chunk], chunks.edges[chunk + 1]):
        I = listed(chunks.node, e)
        if nodes.has_mass[I] == 0 or _awaits(awaiting, I):
            continue
        m = nodes.mass[I]
        if m > small and is_unconstrained(nodes, external, I):
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
                old = apply_prescribed_velocity(external, I, d, m, old)
            work += 0.5 * dt * force * (2.0 * mean - old - nodes.strain_velocity[I, d])
    sums[first + chunk, 0] = work + 0.5 * dt * total(power)
