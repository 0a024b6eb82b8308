"""Transfers between points and nodes: scatter and gather, generic in shape functions, transfer and law.

Work is shared by slabs of cells. Slabs of one colour never reach the same node, so no scatter needs atomics, and every nodal
sum is added in the order of the points: the same bits on any number of threads.

The kernels take a body as the bundle of its `MappedPoints`. Flags are integers 0 or 1.
"""

from math import inf, sqrt
from typing import Any, NamedTuple

from numpy import intp

from pellucid.grid.points import (
    DISSIPATED,
    HEATING,
    INVERTED,
    KINETIC,
    LOSS,
    LOST,
    LUMPING,
    MOMENTUM_X,
    MOMENTUM_Y,
    MOMENTUM_Z,
    NOT_FINITE,
    OK,
    POWER,
    RATE,
    SPEED,
    STORED,
    MappedPoints,
    place_of,
)
from pellucid.grid.stencil import (
    add_internal_force,
    add_momentum,
    add_scalar,
    gather_increments,
    gather_with_gradient,
    node_at,
    stencil,
)
from pellucid.grid.transfer_heat import further_heat, lumping_heat
from pellucid.grid.velocity_transfer import affine_of, affine_velocity, new_velocity
from pellucid.jit import kernel, pointwise
from pellucid.jit.parallel import parallel_by_colour, parallel_for
from pellucid.materials.law import (
    artificial_heating,
    diffusivity,
    dissipated_energy,
    signal_speed,
    stored_energy,
    update,
    volume_growth,
)
from pellucid.materials.point_state import load, store
from pellucid.tensors import end_stress_power


class StrainedPoints(NamedTuple):
    """Points that the velocity gradient strains, and their law."""

    mapped: MappedPoints
    law: Any
    state: Any  # arrays of the state of the law


@kernel(inner=True)
def _scatter_slab(s, mapped, inertia, force):
    functions, transfer, lattice, nodes = mapped.functions, mapped.transfer, mapped.lattice, mapped.nodes
    points, slabs, affine, index = mapped.points, mapped.slabs, mapped.affine, mapped.index
    v = points.velocity
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about = stencil(functions, lattice, points.position, p)
        if inertia:
            m = points.mass[p]
            add_scalar(about, lattice, nodes.mass, m)
            C = affine_of(transfer, affine, p)
            add_momentum(about, lattice, nodes.momentum, transfer, m, (v[p, 0], v[p, 1], v[p, 2]), C)
        if force:
            add_internal_force(about, lattice, nodes.force, points.volume, points.stress, p)


@kernel()
def scatter(n, mapped, inertia, force):
    """Map mass and momentum (where `inertia`) and internal forces -Σ V σ ∇N (where `force`) of n slabs to the nodes."""
    parallel_by_colour(_scatter_slab, n, mapped, inertia, force)


@pointwise
def placed(lattice, x, p, dx, dy, dz, lowest, highest):
    """Move point p; the fault of its new position, and 1 where it lies beyond the layers lowest to highest of its slab."""
    h, low, n = lattice.inverse_cell, lattice.lower, lattice.counts
    x[p, 0] += dx
    x[p, 1] += dy
    x[p, 2] += dz
    X, Y, Z = (x[p, 0] - low[0]) * h, (x[p, 1] - low[1]) * h, (x[p, 2] - low[2]) * h
    along = X if lattice.slab_axis == 0 else (Y if lattice.slab_axis == 1 else Z)
    beyond = 1 if along < lowest or along >= highest else 0
    if X >= 0.0 and n[0] >= X and Y >= 0.0 and n[1] >= Y and Z >= 0.0 and n[2] >= Z:
        return OK, beyond
    return (LOST if abs(X + Y + Z) < inf else NOT_FINITE), beyond


@kernel(inner=True)
def _update_velocities_slab(s, mapped, remap):
    functions, transfer, lattice, nodes = mapped.functions, mapped.transfer, mapped.lattice, mapped.nodes
    points, slabs, affine, index = mapped.points, mapped.slabs, mapped.affine, mapped.index
    v, heat = points.velocity, mapped.heat
    kinetic = px = py = pz = speed = lumping = lost = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about = stencil(functions, lattice, points.position, p)
        new, change, squares = gather_increments(
            about, lattice, nodes.velocity, nodes.velocity_increment, nodes.increment_energy
        )
        m = points.mass[p]
        by_lumping = lumping_heat(squares, change)
        if len(affine) == 0:
            heat[p] = by_lumping + further_heat(transfer, about, lattice, nodes, (v[p, 0], v[p, 1], v[p, 2]), new, change)
        lumping += m * by_lumping
        lost += m * heat[p]
        vx = new_velocity(transfer, v[p, 0], new[0], change[0])
        vy = new_velocity(transfer, v[p, 1], new[1], change[1])
        vz = new_velocity(transfer, v[p, 2], new[2], change[2])
        v[p, 0] = vx
        v[p, 1] = vy
        v[p, 2] = vz
        vv = vx * vx + vy * vy + vz * vz
        kinetic += 0.5 * m * vv
        px += m * vx
        py += m * vy
        pz += m * vz
        speed += m * sqrt(vv)
        if remap:
            C = affine_of(transfer, affine, p)
            add_momentum(about, lattice, nodes.momentum, transfer, m, (vx, vy, vz), C)
    slabs.sums[s, KINETIC] = kinetic
    slabs.sums[s, MOMENTUM_X] = px
    slabs.sums[s, MOMENTUM_Y] = py
    slabs.sums[s, MOMENTUM_Z] = pz
    slabs.sums[s, SPEED] = speed
    slabs.sums[s, LUMPING] = lumping
    slabs.sums[s, LOSS] = lost


@kernel()
def update_velocities(n, mapped, remap):
    """New velocities of the points; where `remap` their momentum mapped to the nodes again.

    Fills `heat` (not that of APIC), and LUMPING and LOSS of the sums, with what the transfer loses of the kinetic energy.
    """
    parallel_by_colour(_update_velocities_slab, n, mapped, remap)


@kernel(inner=True)
def _update_stress_slab(s, strained, dt, move):
    mapped, law, arrays = strained.mapped, strained.law, strained.state
    functions, lattice, nodes, index = mapped.functions, mapped.lattice, mapped.nodes, mapped.index
    points, slabs = mapped.points, mapped.slabs
    x, v, mass, volume = points.position, points.velocity, points.mass, points.volume
    h = lattice.inverse_cell
    stored = dissipated = heating = power = rate = 0.0
    lowest, highest = slabs.layer[s] - 1.0, slabs.layer[s + 1] + 1.0
    left_slab = first_fault = at_fault = 0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        L, new = gather_with_gradient(stencil(functions, lattice, x, p), lattice, nodes.strain_velocity, nodes.velocity)
        fault = OK
        if move:
            fault, beyond = placed(lattice, x, p, dt * new[0], dt * new[1], dt * new[2], lowest, highest)
            left_slab |= beyond
        growth = volume_growth(law, L, dt)
        if growth > 0.0:
            volume[p] *= growth
            m = mass[p]
            density = m / volume[p]
            state = update(law, load(arrays, p), density, L, dt, lattice.cell)
            store(arrays, p, state)
            energy = stored_energy(law, state, density)
            c = signal_speed(law, state, density, L, lattice.cell)
            speed = sqrt(v[p, 0] * v[p, 0] + v[p, 1] * v[p, 1] + v[p, 2] * v[p, 2])
            stored += m * energy
            dissipated += m * dissipated_energy(law, state, density)
            power += volume[p] * end_stress_power(state.stress, L, dt)
            heating += m * artificial_heating(law, state, density, L, lattice.cell)
            rate = max(rate, h * (c + speed), 2.0 * h * h * diffusivity(law, density))
            if not abs(energy + state.stress[0] + state.stress[1] + state.stress[2] + speed + c) < inf:
                fault = NOT_FINITE
        else:
            fault = INVERTED if growth <= 0.0 else NOT_FINITE
        if fault != OK and first_fault == OK:
            first_fault = fault
            at_fault = intp(p)  # type: ignore[assignment]
    slabs.left_slab[s] = left_slab
    slabs.fault[s, 0] = first_fault
    slabs.fault[s, 1] = at_fault
    slabs.sums[s, STORED] = stored
    slabs.sums[s, DISSIPATED] = dissipated
    slabs.sums[s, HEATING] = heating
    slabs.sums[s, POWER] = power
    slabs.sums[s, RATE] = rate


@kernel()
def update_stress(n, strained, dt, move):
    """Velocity gradients, new volumes and stresses; where `move` new positions. Fills STORED, DISSIPATED, HEATING,
    POWER, RATE of the sums.

    strained: the bundle of `StrainedPoints`.
    """
    parallel_for(_update_stress_slab, n, strained, dt, move)


@kernel(inner=True)
def _update_positions_slab(s, mapped, velocity, dt):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    lowest, highest = slabs.layer[s] - 1.0, slabs.layer[s + 1] + 1.0
    left_slab = first_fault = at_fault = 0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        _, v = gather_with_gradient(stencil(functions, lattice, x, p), lattice, velocity, velocity)
        fault, beyond = placed(lattice, x, p, dt * v[0], dt * v[1], dt * v[2], lowest, highest)
        left_slab |= beyond
        if fault != OK and first_fault == OK:
            first_fault = fault
            at_fault = intp(p)  # type: ignore[assignment]
    slabs.left_slab[s] = left_slab
    if first_fault != OK:  # what `update_stress` found earlier in the step stays
        slabs.fault[s, 0] = first_fault
        slabs.fault[s, 1] = at_fault


@kernel()
def update_positions(n, mapped, velocity, dt):
    """New positions alone, by nodal velocities [m/s], shape (nodes, 3), for what is strained otherwise or before it moves."""
    parallel_for(_update_positions_slab, n, mapped, velocity, dt)


@kernel(inner=True)
def _sum_slab(s, mapped):
    points, slabs, index = mapped.points, mapped.slabs, mapped.index
    v = points.velocity
    kinetic = px = py = pz = speed = 0.0
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        m = points.mass[p]
        vv = v[p, 0] * v[p, 0] + v[p, 1] * v[p, 1] + v[p, 2] * v[p, 2]
        kinetic += 0.5 * m * vv
        px += m * v[p, 0]
        py += m * v[p, 1]
        pz += m * v[p, 2]
        speed += m * sqrt(vv)
    slabs.sums[s, KINETIC] = kinetic
    slabs.sums[s, MOMENTUM_X] = px
    slabs.sums[s, MOMENTUM_Y] = py
    slabs.sums[s, MOMENTUM_Z] = pz
    slabs.sums[s, SPEED] = speed


@kernel()
def sum_momentum(n, mapped):
    """Kinetic energy and momentum of the points of n slabs, after their velocities were changed."""
    parallel_for(_sum_slab, n, mapped)


@kernel(inner=True)
def _scatter_momentum_slab(s, mapped):
    functions, transfer, lattice, index = mapped.functions, mapped.transfer, mapped.lattice, mapped.index
    points, slabs, affine, momentum = mapped.points, mapped.slabs, mapped.affine, mapped.nodes.momentum
    v = points.velocity
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        about = stencil(functions, lattice, points.position, p)
        wx, wy, wz, first, place = about.wx, about.wy, about.wz, about.first, about.place
        C = affine_of(transfer, affine, p)
        for a in range(len(wx)):
            dx = (first[0] + a - place[0]) * lattice.cell
            for b in range(len(wy)):
                dy = (first[1] + b - place[1]) * lattice.cell
                for c in range(len(wz)):
                    dz = (first[2] + c - place[2]) * lattice.cell
                    I = node_at(about, lattice, a, b, c)
                    w = wx[a] * wy[b] * wz[c] * points.mass[p]  # in this order: `add_momentum` rounds otherwise
                    momentum[I, 0] += w * affine_velocity(transfer, v[p, 0], C[0], C[1], C[2], dx, dy, dz)
                    momentum[I, 1] += w * affine_velocity(transfer, v[p, 1], C[3], C[4], C[5], dx, dy, dz)
                    momentum[I, 2] += w * affine_velocity(transfer, v[p, 2], C[6], C[7], C[8], dx, dy, dz)


@kernel()
def scatter_momentum(n, mapped):
    """Momentum of the points of n slabs to the nodes, after their velocities were changed (MUSL)."""
    parallel_by_colour(_scatter_momentum_slab, n, mapped)
