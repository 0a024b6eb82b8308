"""Loops over chunks of nodes with sums for each chunk: the nodal operations of the conjugate gradient method in
`pellucid.grid.implicit_viscosity`."""

from typing import NamedTuple

import numpy as np

from pellucid.grid.momentum import sum_loads
from pellucid.grid.nodal_conditions import MASS_EPS, apply_rule, find_rule
from pellucid.grid.viscous_rows import ViscousRows
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_for, parallel_loop
from pellucid.jit.vector import LANES, load, nothing, row, store, total

DESCENT, RESIDUAL, CHANGE, ROUNDING, COLUMNS = range(5)
"""Columns of the sums of a chunk of nodes: DESCENT, the residual r times the preconditioned residual, or p·Ap with the
search direction p and the matrix A [J]; twice the energies of the residual, of the change by viscosity, and of the rounding
error of the operator on the velocities [J]."""


class ViscousNodes(NamedTuple):
    """Nodes of a velocity field, the nodal vectors of the conjugate gradient method for implicit viscosity, and its sums over
    chunks of nodes."""

    field: Bundle  # of `AdvancedNodes`
    own: ViscousRows  # vectors of the conjugate gradient method
    sums: np.ndarray  # (chunks, COLUMNS) sums of each chunk


@kernel(inner=True)
def _begin_chunk(chunk, viscous, dt):
    field, own = viscous.field, viscous.own
    nodes, gravity = field.nodes, field.gravity
    loaded, apart = len(field.load) > 0, len(field.separate_forces) > 0
    zero = row(0.0, 0.0, 0.0, 0.0)
    for I in range(field.edges[chunk], field.edges[chunk + 1]):
        m = nodes.mass[I]
        store(own.viscous_force, 4 * I, zero)
        store(own.inverse, 4 * I, zero)
        store(own.inertia, 4 * I, zero)
        store(own.target, 4 * I, zero)
        store(own.solution, 4 * I, zero)
        if m < MASS_EPS:
            continue
        for d in range(3):
            k, old, force = 4 * I + d, nodes.momentum[I, d] / m, nodes.force[I, d]
            if apart:
                force += field.separate_forces[k]
            if loaded:
                force += field.load[I, d]
            rule = find_rule(field, nodes.constrained[I, d], I, d, m, dt)
            new = apply_rule(rule, old, old + dt * (gravity[d] + force / m))
            inertia = m / ((1.0 - rule.absorbed) * (1.0 - rule.share)) if rule.share < 1.0 else 0.0
            own.target[k], own.inertia[k] = new, inertia
            own.solution[k] = old if inertia > 0.0 else new


@kernel()
def begin(n, viscous, dt):
    """Compute, for n chunks of nodes, the velocities after a step dt [s] without viscosity (`target`), the initial velocities
    of the iteration (`solution`), and the effective masses (`inertia`, 0 where the velocity is prescribed); viscous:
    `ViscousNodes`."""
    sum_loads(n, viscous.field)
    parallel_for(_begin_chunk, n, viscous, dt)


@parallel_loop()
def start(chunk, viscous, dt, lightest):
    """Compute the residual of the initial velocities of a chunk of nodes from their viscous forces, and the sums of the
    chunk, for the conjugate gradient method; viscous: `ViscousNodes`.

    On entry, `inverse` contains the diagonal of the viscous operator without the masses. lightest: smallest mass of a point
    [kg], with which lighter nodes count, see `pellucid.grid.implicit_viscosity`. dt: step [s].
    """
    own = viscous.own
    descent = residual = change = rounding = 0.0
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        for k in range(4 * I, 4 * I + 3):
            m, v = own.inertia[k], own.solution[k]
            off = v - own.target[k]
            if m > 0.0:
                diagonal, weight = m + dt * own.inverse[k], 1.0 / max(m, lightest)
                r = dt * own.viscous_force[k] - m * off
                own.inverse[k], own.weight[k] = 1.0 / diagonal, weight
                descent += r * r / diagonal
                residual += weight * r * r
                change += m * off * off
                rounding += weight * (diagonal * v) ** 2
                own.residual[k], own.direction[k] = r, 0.0
            else:
                own.inverse[k] = own.weight[k] = own.residual[k] = own.direction[k] = 0.0
    sums = viscous.sums
    sums[chunk, DESCENT], sums[chunk, RESIDUAL], sums[chunk, CHANGE] = descent, residual, change
    sums[chunk, ROUNDING] = rounding


@parallel_loop()
def find_curvature(chunk, viscous, dt):
    """Compute p·Ap [J] with the search direction p of the conjugate gradient method and the matrix A = m + dt K (masses m,
    step dt [s], viscous operator K), from the viscous forces of p; a sum for each chunk of nodes.

    viscous: `ViscousNodes`.
    """
    own = viscous.own
    along = row(0.0, 0.0, 0.0, 0.0)
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        p = load(own.direction, 4 * I)
        along += p * (load(own.inertia, 4 * I) * p - dt * load(own.viscous_force, 4 * I))
    viscous.sums[chunk, DESCENT] = total(along)


@parallel_loop()
def move(chunk, viscous, dt, step):
    """Add `step` times the search direction of the conjugate gradient method to the velocities of a chunk of nodes, and
    update the residual and the sums of the chunk; reset the viscous forces to zero; viscous: `ViscousNodes`; dt: time step
    [s]."""
    own = viscous.own
    zero = row(0.0, 0.0, 0.0, 0.0)
    descent, residual, change = nothing(zero), nothing(zero), nothing(zero)
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        k = 4 * I
        p, m = load(own.direction, k), load(own.inertia, k)
        v = load(own.solution, k) + step * p
        r = load(own.residual, k) - step * (m * p - dt * load(own.viscous_force, k))
        off = v - load(own.target, k)
        store(own.solution, k, v)
        store(own.residual, k, r)
        store(own.viscous_force, k, zero)
        descent += load(own.inverse, k) * (r * r)
        residual += load(own.weight, k) * (r * r)
        change += m * (off * off)
    sums = viscous.sums
    sums[chunk, DESCENT], sums[chunk, RESIDUAL], sums[chunk, CHANGE] = total(descent), total(residual), total(change)


@parallel_loop()
def turn(chunk, viscous, share):
    """Compute the next search direction of the conjugate gradient method for a chunk of nodes: the preconditioned residual
    plus `share` times the last direction; reset the viscous forces to zero; viscous: `ViscousNodes`."""
    own, zero = viscous.own, row(0.0, 0.0, 0.0, 0.0)
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        k = 4 * I
        p = load(own.inverse, k) * load(own.residual, k) + share * load(own.direction, k)
        store(own.direction, k, p)
        store(own.viscous_force, k, zero)


@parallel_loop()
def add_forces(chunk, viscous, forces):
    """Add the viscous forces of the solution to the internal forces of a chunk of nodes, `forces` [N], shape (4 nodes,);
    viscous: `ViscousNodes`."""
    for k in range(4 * viscous.field.edges[chunk], 4 * viscous.field.edges[chunk + 1], LANES):
        store(forces, k, load(forces, k) + load(viscous.own.viscous_force, k))


@parallel_loop()
def sum_lag(chunk, viscous):
    """Compute the power [W] of the viscous forces of a chunk of nodes along the difference between the solution and the
    mean velocities of the step, in the column DESCENT of the sums of chunks; viscous: `ViscousNodes`."""
    nodes, own = viscous.field.nodes, viscous.own
    power = 0.0
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        for d in range(3 if nodes.has_mass[I] else 0):
            k = 4 * I + d
            power += own.viscous_force[k] * (own.solution[k] - nodes.mean_velocity[I, d])
    viscous.sums[chunk, DESCENT] = power
