"""A step of the nodes, and the works along the means of their velocities before and after it."""

from pellucid.energy import ABSORBED, FIRST_LOAD, GRAVITY, IMPACT, INTERNAL, MOTION
from pellucid.grid.momentum import CHUNK, NOTHING, advance_chunk, driven_velocity, following, moves_freely, what_acts
from pellucid.jit import kernel
from pellucid.jit.local import numbers
from pellucid.jit.parallel import parallel_for
from pellucid.jit.vector import LANES, load, nothing, row, store, total


@kernel(inner=True)
def _count_works_chunk(chunk, field, dt, small):
    nodes, external, gravity, work = field.nodes, field.external, field.gravity, field.work
    mass, force, velocity, velocity_increment = nodes.mass, nodes.force, nodes.velocity, nodes.velocity_increment
    acts = what_acts(field)
    loaded, absorbing, driven = acts
    of_rows = numbers(LANES)
    of_velocity = row(1.0, 1.0, 1.0, 0.0)
    power, momentum = nothing(of_velocity), nothing(of_velocity)
    internal = fall = sum_of_masses = absorbed = moved = lost = 0.0
    columns = FIRST_LOAD + len(external.loads)
    others = columns + 1 + 3 * len(field.supports.velocity)
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(mass))):
        m, energy = mass[I], 0.0
        if m < NOTHING:  # most of the nodes
            store(nodes.mean_velocities, 4 * I, nothing(power))
            nodes.increment_energy[I] = 0.0
            continue
        sum_of_masses += m
        if m > small and moves_freely(field, acts, I):
            change = of_velocity * load(nodes.increments, 4 * I)
            mean_row = load(nodes.velocities, 4 * I) - 0.5 * change
            store(nodes.mean_velocities, 4 * I, mean_row)
            nodes.increment_energy[I] = 0.5 * total(change * change)
            power += load(nodes.forces, 4 * I) * mean_row
            momentum += m * mean_row
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
            elif driven and external.driven_mass[I, d] > 0.0:
                given, goal = external.impulse[I, d] * external.driven_mass[I, d], driven_velocity(external, I, d)
                follow = following(external, I, d, m)
                other = dt * (force[I, d] + m * gravity[d] + external_force)
                moved += given * goal
                lost += (given + follow * other) * (goal - mean)
                mean += follow * (goal - mean)
                mean_of_gravity = mean
            nodes.mean_velocity[I, d] = mean
            internal += dt * force[I, d] * mean
            fall += dt * m * gravity[d] * mean_of_gravity
            if absorbing and external.absorbed[I, d] != 0.0:
                absorbed -= external.absorbed[I, d] * mean
                work[chunk, others + d] += external.absorbed[I, d]
            if external_force != 0.0:
                work[chunk, others + d] += dt * external_force
                for k in range(len(external.loads)):
                    work[chunk, FIRST_LOAD + k] += dt * external.loads[k, I, d] * mean
        nodes.increment_energy[I] = energy
    store(of_rows, 0, momentum)
    for d in range(3):
        fall += dt * gravity[d] * of_rows[d]
    work[chunk, INTERNAL] = internal + dt * total(power)
    work[chunk, GRAVITY] = fall
    work[chunk, ABSORBED] = absorbed
    work[chunk, MOTION] = moved
    work[chunk, IMPACT] += lost
    work[chunk, columns] = sum_of_masses


@kernel()
def count_works(chunks, field, dt, small):
    """Works of the step and impulses on nodes, with mean velocities; see `NodalMomentum.works`."""
    parallel_for(_count_works_chunk, chunks, field, dt, small)


@kernel(inner=True)
def _sum_loads_chunk(chunk, field):
    loads = field.external.loads
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(field.load))):
        for d in range(3):
            external_force = 0.0
            for k in range(len(loads)):
                external_force += loads[k, I, d]
            field.load[I, d] = external_force


@kernel(inner=True)
def _add_apart_chunk(chunk, field):
    forces, apart = field.nodes.forces, field.apart
    for k in range(4 * CHUNK * chunk, min(4 * CHUNK * (chunk + 1), len(apart)), LANES):
        store(forces, k, load(forces, k) + load(apart, k))


@kernel(inner=True)
def _advance_chunk(chunk, field, dt, small, flip, counted):
    advance_chunk(chunk, field, dt, small, flip)
    if counted:
        _count_works_chunk(chunk, field, dt, small)


@kernel()
def advance(chunks, field, dt, small, flip, counted):
    """The momentum equation of all nodes; where `counted`, their works too, while the nodes are at hand."""
    if len(field.apart) > 0:
        parallel_for(_add_apart_chunk, chunks, field)
    if len(field.load) > 0:  # apart: loops over the channels within the momentum equation would slow down all nodes
        parallel_for(_sum_loads_chunk, chunks, field)
    parallel_for(_advance_chunk, chunks, field, dt, small, flip, counted)


@kernel(inner=True)
def _sum_strain_lag_chunk(chunk, field, dt, small, sums):
    nodes, external, work, several = field.nodes, field.external, 0.0, len(field.apart) > 0
    acts = what_acts(field)
    driven = acts[2]
    power = row(0.0, 0.0, 0.0, 0.0)
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(nodes.mass))):
        if nodes.mass[I] < NOTHING:
            continue
        if nodes.mass[I] > small and moves_freely(field, acts, I):
            force_row = load(nodes.forces, 4 * I)
            if several:
                force_row -= load(field.apart, 4 * I)
            old_row = load(nodes.velocities, 4 * I) - load(nodes.increments, 4 * I)
            power += force_row * (2.0 * load(nodes.mean_velocities, 4 * I) - old_row - load(nodes.strain_velocities, 4 * I))
            continue
        for d in range(3):
            mean = nodes.mean_velocity[I, d]
            force = nodes.force[I, d] - field.apart[4 * I + d] if several else nodes.force[I, d]
            old = mean
            if nodes.mass[I] > small or nodes.constrained[I, d] > 0:
                old = nodes.velocity[I, d] - nodes.velocity_increment[I, d]
            if driven and nodes.constrained[I, d] == 0 and external.driven_mass[I, d] > 0.0:  # as points were strained along it
                old += following(external, I, d, nodes.mass[I]) * (driven_velocity(external, I, d) - old)
            work += 0.5 * dt * force * (2.0 * mean - old - nodes.strain_velocity[I, d])
    sums[chunk, 0] = work + 0.5 * dt * total(power)


@kernel()
def sum_strain_lag(chunks, field, dt, small, sums):
    """See `NodalMomentum.strain_lag_work`; a sum for each chunk."""
    parallel_for(_sum_strain_lag_chunk, chunks, field, dt, small, sums)
