"""Kernels of the conjugate gradient method in `pellucid.grid.implicit_viscosity`: loops over chunks of nodes, with sums for
each chunk, and over the points of fluids.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.grid.momentum import sum_loads
from pellucid.grid.nodal_conditions import MASS_EPS, apply_rule, find_rule
from pellucid.grid.nodal_fields import with_fields
from pellucid.grid.particle_to_grid import InternalForce, InternalForceRead, InternalForceWithoutPressure
from pellucid.grid.passes.gifts import BySquare, by_slope, giving
from pellucid.grid.passes.points_pass import Declaration, Found, at_point, gathered, pass_points
from pellucid.grid.points import HEATING, OK, POWER, PRESSURE_CHANGE, FullCells, MappedPoints, NoCells, cell_at, place_of
from pellucid.grid.stencil import gather_gradient
from pellucid.grid.viscous_rows import ViscousRows
from pellucid.jit import generic, kernel, point_function, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_for, parallel_loop
from pellucid.jit.memory import numbers
from pellucid.jit.vector import LANES, load, nothing, row, store, total
from pellucid.materials.rheology import SecondViscosity, UniformViscosity
from pellucid.tensors import IDENTITY, double_dot, symmetric_part

DESCENT, RESIDUAL, CHANGE, ROUNDING, SIZE, WORK, COLUMNS = range(7)
"""Columns of the sums of a chunk of nodes: DESCENT, the residual r times the preconditioned residual, or p·Ap with the
search direction p and the matrix A [J]; twice the energies of the residual, of the change by viscosity, of the rounding error
of the operator on the velocities, and of the velocities [J]; WORK, the residual times the velocities [J]."""


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


@pointwise
def along_wall(own, k, vector):
    """Return a vector of the node whose rows start at k without its component along the normal of a wall that prescribes the
    velocity along this normal; own: `ViscousRows`, without memory for normals in a field without such walls."""
    if len(own.normal) == 0:
        return vector
    normal = load(own.normal, k)
    return vector - total(normal * vector) * normal


@parallel_loop()
def extrapolate_velocities(chunk, viscous, share, growth):
    """Change the velocities without viscosity of a chunk of nodes from those after the step to those at the time of the
    solution, and extrapolate the initial velocities of the iteration from the solutions of the two steps before; viscous:
    `ViscousNodes`.

    share: time of the solution, as a share of the step; growth: this step divided by the last, 0 for no extrapolation. Nodes
    without fluid in one of the two steps keep their initial velocities, those at the start of the step.
    """
    own, change = viscous.own, numbers(LANES)
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        k = 4 * I
        known = growth > 0.0 and own.latest[k + 3] * own.before[k + 3] > 0.0
        v, latest = load(own.solution, k), load(own.latest, k)
        store(change, 0, along_wall(own, k, latest + growth * (latest - load(own.before, k)) - v))
        for d in range(3):
            if own.inertia[k + d] > 0.0:
                old = own.solution[k + d]
                own.target[k + d] = old + share * (own.target[k + d] - old)
                if known:
                    own.solution[k + d] = old + change[d]


@parallel_loop()
def store_solution(chunk, viscous):
    """Store the solution of this step at a chunk of nodes as the latest, for `extrapolate_velocities`; viscous:
    `ViscousNodes`."""
    own, nodes = viscous.own, viscous.field.nodes
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        k = 4 * I
        store(own.latest, k, load(own.solution, k))
        own.latest[k + 3] = 1.0 if nodes.mass[I] >= MASS_EPS else 0.0


@parallel_loop()
def start(chunk, viscous, dt, lightest):
    """Compute the residual of the initial velocities of a chunk of nodes from their viscous forces, and the sums of the
    chunk, for the conjugate gradient method; viscous: `ViscousNodes`.

    On entry, `inverse` contains the diagonal of the viscous operator without the masses. lightest: smallest mass of a point
    [kg], with which lighter nodes count, see `pellucid.grid.implicit_viscosity`. dt: time over which the forces act [s].
    """
    own = viscous.own
    residual = change = rounding = whole = work = 0.0
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        for k in range(4 * I, 4 * I + 3):
            m, v = own.inertia[k], own.solution[k]
            if m > 0.0:
                off = v - own.target[k]
                diagonal, weight = m + dt * own.inverse[k], 1.0 / max(m, lightest)
                own.inverse[k], own.weight[k] = 1.0 / diagonal, weight
                change += m * off * off
                whole += m * v * v
                rounding += weight * (diagonal * v) ** 2
                own.residual[k], own.direction[k] = dt * own.viscous_force[k] - m * off, 0.0
            else:
                own.inverse[k] = own.weight[k] = own.residual[k] = own.direction[k] = own.preconditioned[k] = 0.0
        if len(own.normal) > 0:
            store(own.residual, 4 * I, along_wall(own, 4 * I, load(own.residual, 4 * I)))
        for k in range(4 * I, 4 * I + 3):
            residual += own.weight[k] * own.residual[k] * own.residual[k]
            work += own.residual[k] * own.solution[k]
    sums = viscous.sums
    sums[chunk, RESIDUAL], sums[chunk, CHANGE] = residual, change
    sums[chunk, ROUNDING], sums[chunk, SIZE], sums[chunk, WORK] = rounding, whole, work


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
    residual, change, work = nothing(zero), nothing(zero), nothing(zero)
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        k = 4 * I
        p, m = load(own.direction, k), load(own.inertia, k)
        v = load(own.solution, k) + step * p
        r = along_wall(own, k, load(own.residual, k) - step * (m * p - dt * load(own.viscous_force, k)))
        off = v - load(own.target, k)
        store(own.solution, k, v)
        store(own.residual, k, r)
        store(own.viscous_force, k, zero)
        residual += load(own.weight, k) * (r * r)
        change += m * (off * off)
        work += r * v
    sums = viscous.sums
    sums[chunk, RESIDUAL], sums[chunk, CHANGE], sums[chunk, WORK] = total(residual), total(change), total(work)


@parallel_loop()
def precondition(chunk, viscous):
    """Divide the residual of a chunk of nodes by the diagonal of the matrix; viscous: `ViscousNodes`."""
    own = viscous.own
    for k in range(4 * viscous.field.edges[chunk], 4 * viscous.field.edges[chunk + 1], LANES):
        store(own.preconditioned, k, load(own.inverse, k) * load(own.residual, k))


@parallel_loop()
def sum_descent(chunk, viscous):
    """Compute the residual times the preconditioned residual of a chunk of nodes [J], without the component of the latter along
    the normals of walls; viscous: `ViscousNodes`."""
    own, descent = viscous.own, row(0.0, 0.0, 0.0, 0.0)
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        z = along_wall(own, 4 * I, load(own.preconditioned, 4 * I))
        store(own.preconditioned, 4 * I, z)
        descent += load(own.residual, 4 * I) * z
    viscous.sums[chunk, DESCENT] = total(descent)


@parallel_loop()
def turn(chunk, viscous, share):
    """Compute the next search direction of the conjugate gradient method for a chunk of nodes: the preconditioned residual
    plus `share` times the last direction; reset the viscous forces to zero; viscous: `ViscousNodes`."""
    own, zero = viscous.own, row(0.0, 0.0, 0.0, 0.0)
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        k = 4 * I
        p = load(own.preconditioned, k) + share * load(own.direction, k)
        store(own.direction, k, p)
        store(own.viscous_force, k, zero)


@parallel_loop()
def add_forces(chunk, viscous, forces, share):
    """Add the viscous forces of the solution to the internal forces of a chunk of nodes, `forces` [N], shape (4 nodes,);
    viscous: `ViscousNodes`."""
    for k in range(4 * viscous.field.edges[chunk], 4 * viscous.field.edges[chunk + 1], LANES):
        store(forces, k, load(forces, k) + share * load(viscous.own.viscous_force, k))


@parallel_loop()
def strain_by_solution(chunk, viscous, share):
    """Let the solution strain the points, with the impulses of the step, but without the error of the momentum that results
    from the residual; for a chunk of nodes. viscous: `ViscousNodes`; share: time of the solution, as a share of the step."""
    nodes, own = viscous.field.nodes, viscous.own
    found = numbers(LANES)
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        lag = (1.0 - share) * along_wall(own, 4 * I, load(nodes.increments, 4 * I))
        store(found, 0, load(nodes.velocities, 4 * I) - lag)
        for d in range(3):
            k = 4 * I + d
            if own.inertia[k] > 0.0:
                nodes.strain_velocity[I, d] = found[d] - own.residual[k] / own.inertia[k]


@parallel_loop()
def keep_forces(chunk, viscous, share):
    """Keep `share` times the viscous forces of a chunk of nodes as `earlier_force`; viscous: `ViscousNodes`."""
    for k in range(4 * viscous.field.edges[chunk], 4 * viscous.field.edges[chunk + 1], LANES):
        store(viscous.own.earlier_force, k, share * load(viscous.own.viscous_force, k))


@parallel_loop()
def sum_lag(chunk, viscous, share):
    """Compute the power [W] of the implicit forces of a chunk of nodes, `share` times the viscous forces, along the difference
    between the solution and the mean velocities of the step, and of the earlier forces along minus the mean velocities, in the
    column DESCENT of the sums of chunks; viscous: `ViscousNodes`."""
    nodes, own = viscous.field.nodes, viscous.own
    power = 0.0
    for I in range(viscous.field.edges[chunk], viscous.field.edges[chunk + 1]):
        for d in range(3 if nodes.has_mass[I] else 0):
            k, mean = 4 * I + d, nodes.mean_velocity[I, d]
            power += share * own.viscous_force[k] * (own.solution[k] - mean)
            if share < 1.0:
                power -= own.earlier_force[k] * mean
    viscous.sums[chunk, DESCENT] = power


class Read(NamedTuple):
    """Input of the loops of implicit viscosity at one point, or the arrays of all points: position, volume and
    viscosity."""

    position: Any  # [m]
    volume: Any  # [m³]
    viscosity: Any  # shear viscosity [Pa s]; () if all points have the same


class Kept(NamedTuple):
    """Output of the loop `straining_by_viscosity` at one point, or the array of all points: the viscous stress."""

    stress: Any  # viscous stress [Pa]


class StressByViscosity(NamedTuple):
    """Operation at each point: computes the stress σ = 2μD + (λ tr(D) - q) I from the strain rate D of the nodal velocity, with
    the change q of the pressure: that of the full cell (a cell that the fluid fills) that contains the point, or -KΔt tr(D)."""

    viscosity: Any  # `UniformViscosity`, or the `SecondViscosity` of points with their own shear viscosities
    stiffness: float  # K = ρc² of a pressure that is solved for [Pa], 0 without
    cells: Any  # `FullCells` or `NoCells`


@generic
def implicit_viscosities(viscosity: Any, own: Any) -> tuple[float, float]:
    """Return the viscosities μ and λ [Pa s] of a point. viscosity: `StressByViscosity.viscosity`; own: `Read.viscosity`."""


@point_function(implicit_viscosities, UniformViscosity)
def _of_all(viscosity, own):
    return viscosity.mu, viscosity.lam


@point_function(implicit_viscosities, SecondViscosity)
def _of_point(viscosity, own):
    return own, viscosity.ratio * own + viscosity.constant


@generic
def change_of_pressure(cells: Any, lattice: Any, p: Any, change: float) -> tuple[float, float]:
    """Return the change of the pressure of a point [Pa]: that of its full cell (a cell that the fluid fills), otherwise
    `change`; and the share of its power, 0 or 1, that is summed over points.

    cells: `FullCells` or `NoCells`; p: input values (`Read`).
    """


@point_function(change_of_pressure, NoCells)
def _of_point_itself(cells, lattice, p, change):
    return change, 1.0


@point_function(change_of_pressure, FullCells)
def _of_cell(cells, lattice, p, change):
    cell = cell_at(lattice, p.position)
    return (cells.found[cell, PRESSURE_CHANGE], 0.0) if cells.full[cell] else (change, 1.0)


@point_function(gathered, StressByViscosity)
def _gradient(rule, about, lattice, nodes, p, known):
    return gather_gradient(about, lattice, nodes.velocity)


@point_function(at_point, StressByViscosity)
def _stress(task, lattice, dt, p, known, g):
    mu, lam = implicit_viscosities(task.viscosity, p.viscosity)
    D, two_mu = symmetric_part(g), 2.0 * mu
    growth = D[0] + D[1] + D[2]
    pressure, share = change_of_pressure(task.cells, lattice, p, -task.stiffness * dt * growth)
    bulk = lam * growth - pressure
    stress = (two_mu * D[0] + bulk, two_mu * D[1] + bulk, two_mu * D[2] + bulk, two_mu * D[3], two_mu * D[4], two_mu * D[5])
    compression = -p.volume * pressure * growth
    power = p.volume * double_dot(stress, D) - compression
    return Found(Kept(stress), (power, share * compression), 0.0, float(OK))


def straining_by_viscosity(
    mapped: MappedPoints,
    rule: StressByViscosity,
    viscosity: np.ndarray | None,
    stress: np.ndarray,
    velocity: np.ndarray,
    force: np.ndarray,
) -> Bundle:
    """Build the loop that computes the implicit stresses of the points of a body, and maps their forces to the nodes; the step
    [s] of the loop is Δt of `StressByViscosity`.

    viscosity: shear viscosity of each point [Pa s], shape (points,); None if all points have the same. stress: output [Pa],
    shape (points, 6). velocity: nodal velocities [m/s], in rows of four numbers, shape (4 nodes,).
    force: nodal rows to which the forces are added [N]. Fills the columns of the sums over points [W] with the power of
    viscosity (POWER) and with the power of the change of pressure outside full cells (HEATING). mapped: the points.
    """
    points = mapped.points
    nodes = with_fields(mapped.nodes, {"velocities": velocity, "forces": force})
    in_cells = not isinstance(rule.cells, NoCells)
    reads = InternalForceRead(points.volume, stress, points.position if in_cells else ())
    gives = by_slope(InternalForceWithoutPressure(rule.cells.full) if in_cells else InternalForce(), reads, force)
    declared = Declaration(gathers=IDENTITY, sums=(POWER, HEATING))
    read, kept = Read(points.position, points.volume, () if viscosity is None else viscosity), Kept(stress)
    return pass_points(rule, declared, mapped._replace(nodes=nodes), read, kept, gives)


def diagonal_by_viscosity(mapped: MappedPoints, volume: np.ndarray, factors: np.ndarray, into: np.ndarray) -> Bundle:
    """Build the loop that adds the diagonal of the viscous operator of a body's points, Σ V (μ |∇N|² + (μ+λ) (∂N/∂x_d)²) along
    each axis d [kg/s], to the nodal rows `into`, shape (4 nodes,).

    volume: V [m³], shape (points,); factors: the numbers μ and 2μ + λ [Pa s], shape (2,). Both may change between loops. For
    points with their own viscosities, `volume` is the product μV, and the factors are 1 and 2 + λ/μ.
    """
    return giving(mapped, BySquare(volume, factors, into))


@parallel_loop()
def add_stress(s, mapped, viscous, share):
    """Add `share` times the viscous stresses `viscous` [Pa], shape (points, 6), to the stresses of the points of slab s (see
    `Slabs`); mapped: the points (`MappedPoints`)."""
    stress, slabs, index = mapped.points.stress, mapped.slabs, mapped.index
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        for k in range(6):
            stress[p, k] += share * viscous[p, k]


@parallel_loop()
def keep_viscous(s, mapped, viscous, share):
    """Remove the change of pressure from the implicit stresses of the points of slab s (see `Slabs`), `viscous` [Pa], shape
    (points, 6), so that the viscous stresses remain; share: share of the viscous stress in the mean stress of each point, shape
    (points,); mapped: the points (`MappedPoints`)."""
    slabs, index = mapped.slabs, mapped.index
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        more = (share[p] - 1.0) / 3.0 * (viscous[p, 0] + viscous[p, 1] + viscous[p, 2])
        for k in range(3):
            viscous[p, k] += more
