"""New velocities of points from the nodes, with the heat of the transfer and the work of internal forces on the grid.

Nodal forces do work along the mean nodal velocity; a body that stores heat receives this work at the points whose stress
did it.
"""

from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from pellucid.grid.particle_to_grid import inertia_of
from pellucid.grid.passes.points_pass import Declaration, Found, ToCells, at_point, gathered, in_cell, looked_up, pass_points
from pellucid.grid.points import (
    AFFINE,
    GAINED,
    KEPT,
    KINETIC,
    LOSS,
    LUMPING,
    MOMENTUM_X,
    MOMENTUM_Y,
    MOMENTUM_Z,
    RATES,
    SPEED,
    FullCells,
    GrowingCells,
    MappedPoints,
    cell_at,
)
from pellucid.grid.stencil import gather, gather_gradient, gather_scalar
from pellucid.grid.transfer_heat import affine_energy, affine_functions, affine_functions_like, kept_heat, lumping_heat, renewed
from pellucid.grid.velocity_transfer import VelocityTransfer, new_velocity
from pellucid.jit import generic, point_function, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.tensors import IDENTITY, ZERO_VECTOR, stress_power

MOTION_SUMS = KINETIC, MOMENTUM_X, MOMENTUM_Y, MOMENTUM_Z, SPEED, LUMPING, LOSS


class Read(NamedTuple):
    """Input of the loop `taking_velocities` at one point, or the arrays of all points: position, velocity and mass, affine
    field (APIC), and data for the work of the stress."""

    position: Any  # [m]
    velocity: Any  # [m/s]
    mass: Any  # [kg]
    affine: Any  # affine field [1/s] and its energy per unit mass [J/kg], ten numbers; () for other transfers than APIC
    worked: Any  # `Worked` with `Work`, the volume [m³] with `Rates`, () with `NoWork`


class Worked(NamedTuple):
    """Volume, stress and internal energy of a point, from which the work of its stress is computed."""

    volume: Any  # [m³]
    stress: Any  # [Pa]
    internal_energy: Any  # [J/kg]


class Kept(NamedTuple):
    """Output of the loop `taking_velocities` at one point, or the arrays of all points: velocity, affine field (APIC), and
    internal energy with the heat of the transfer, after the step."""

    velocity: Any  # [m/s]
    affine: Any  # affine field [1/s] and its energy, or ()
    worked: Any  # internal energy and heat of the transfer [J/kg], or ()


class Gathered(NamedTuple):
    """Values that a point gathers from the nodes: its new velocity and affine field, heat of the transfer, and velocity
    gradient."""

    velocity: Any  # velocity of the point after the step [m/s]
    lumping: Any  # heat of lumping per unit mass [J/kg]
    heat: Any  # heat of the whole transfer per unit mass [J/kg]
    affine: Any  # new affine field and its energy, or ()
    gradient: Any  # gradient of the mean velocity [1/s], or ()


class TakeVelocity(NamedTuple):
    """Operation at each point: computes its new velocity, affine field (APIC), and the energies of points that store internal
    energy."""

    transfer: Any  # `VelocityTransfer`
    work: Any  # `NoWork`, `Work`, `WorkInCells` or `Rates`: its type selects what is computed in addition to velocities


class NoWork(NamedTuple):
    """Type of `TakeVelocity.work` that selects kernels for points without internal energy: these compute only velocities."""


class Work(NamedTuple):
    """Type of `TakeVelocity.work` that selects kernels for points with internal energy: these also add to the energy of a
    point the work of its stress and, as heat, the kinetic energy that the transfer between points and grid loses."""


class WorkInCells(NamedTuple):
    """Type of `TakeVelocity.work` for a fluid with an implicit pressure: as `Work`, but without the work of the pressures in
    full cells (cells that the fluid fills), which do work along the growth of these cells."""

    full: np.ndarray  # see `FullCells`


class Rates(NamedTuple):
    """Type of `TakeVelocity.work` that selects kernels for points without internal energy in a fluid whose pressures are
    averaged in full cells (cells that the fluid fills): these also add the volume growth rate of each point [m³/s] to the
    sum of its grid cell."""


@generic
def mean_gradient(work: Any, about: Any, lattice: Any, nodes: Any) -> Any:
    """Return the gradient of the mean nodal velocity of the step at the point with the stencil `about` [1/s], or () if the
    option `work` does not need it; nodes: nodal arrays."""


@generic
def work_at_point(work: Any, lattice: Any, transfer: Any, dt: float, p: Any, L: Any, heat: float) -> Any:
    """For a point that stores internal energy, return two pairs: the new internal energy and the heat of the transfer per
    unit mass [J/kg]; the energy added to the point in the step, and the heat in this energy [J]. For other points return
    two empty tuples.

    work: `NoWork`, `Work`, `WorkInCells` or `Rates`; p: input values (`Read`); L: result of `mean_gradient`; heat: energy lost
    by the transfer [J/kg]. dt: step [s].
    """


@generic
def volume_of(work: Any, p: Any) -> Any:
    """Return the volume of a point [m³], by which its relative growth rate is multiplied before it is added to the sum of
    its cell; p: input values (`Read`); work: `Work` or `Rates`."""


@point_function(mean_gradient, NoWork)
def _no_gradient(work, about, lattice, nodes):
    return ()


@point_function(mean_gradient, Work)
@point_function(mean_gradient, WorkInCells)
@point_function(mean_gradient, Rates)
def _gradient(work, about, lattice, nodes):
    return gather_gradient(about, lattice, nodes.mean_velocity)


@point_function(work_at_point, NoWork)
@point_function(work_at_point, Rates)
def _no_work(work, lattice, transfer, dt, p, L, heat):
    return (), ()


@point_function(work_at_point, Work)
def _work(work, lattice, transfer, dt, p, L, heat):
    return _with_work(transfer, dt * stress_power(p.worked.stress, L), p, heat)


@point_function(work_at_point, WorkInCells)
def _work_in_cells(work, lattice, transfer, dt, p, L, heat):
    stress = p.worked.stress
    mean = (stress[0] + stress[1] + stress[2]) / 3.0 if work.full[cell_at(lattice, p.position)] else 0.0
    return _with_work(transfer, dt * (stress_power(stress, L) - mean * (L[0] + L[4] + L[8])), p, heat)


@pointwise
def _with_work(transfer, work, p, heat):
    """Return the result of `work_at_point` for the work of the stress per unit volume `work` [J/m³]."""
    m, kept = p.mass, kept_heat(transfer, heat)
    more = p.worked.volume / m * work + kept
    return (p.worked.internal_energy + more, heat), (m * more, m * kept)


@point_function(volume_of, Work)
def _of_worked(work, p):
    return p.worked.volume


@point_function(volume_of, Rates)
def _of_rates(work, p):
    return p.worked


@point_function(looked_up, TakeVelocity)
def _look_up(rule, lattice, functions, about, p):
    return affine_functions(rule.transfer, functions, about)


@point_function(gathered, TakeVelocity)
def _gather(rule, about, lattice, nodes, p, known):
    v, by = p.velocity, rule.transfer
    change, mapped = gather(about, lattice, nodes.velocity_increment), gather(about, lattice, nodes.velocity)
    lumping = lumping_heat(gather_scalar(about, lattice, nodes.increment_energy), change)
    new = (
        new_velocity(by, v[0], mapped[0], change[0]),
        new_velocity(by, v[1], mapped[1], change[1]),
        new_velocity(by, v[2], mapped[2], change[2]),
    )
    affine, heat = renewed(by, about, lattice, nodes, p, known, new, mapped, change, lumping)
    return Gathered(new, lumping, heat, affine, mean_gradient(rule.work, about, lattice, nodes))


@point_function(at_point, TakeVelocity)
def _take(task, lattice, dt, p, known, g):
    (x, y, z), lumping, heat, affine, L = g  # as `Gathered` has them
    m, vv = p.mass, x * x + y * y + z * z
    worked, gained = work_at_point(task.work, lattice, task.transfer, dt, p, L, heat)
    motion = 0.5 * m * vv, m * x, m * y, m * z, m * sqrt(vv), m * lumping, m * heat
    return Found(Kept((x, y, z), affine, worked), (motion, gained, affine_energy(task.transfer, m, affine)), 0.0, 0.0)


@point_function(in_cell, TakeVelocity)
def _rate_of_volume(task, p, g):
    L = g.gradient
    return volume_of(task.work, p) * (L[0] + L[4] + L[8])


class HeatArrays(NamedTuple):
    """Arrays of a body whose points store internal energy, to which `taking_velocities` writes: the specific internal
    energy, and the energy that the transfer lost at each point in a step."""

    energy: np.ndarray  # (points,) specific internal energy [J/kg]
    heat: np.ndarray  # (points,) energy lost by the transfer at each point in a step [J/kg]


def taking_velocities(
    transfer: VelocityTransfer,
    mapped: MappedPoints,
    affine: np.ndarray | None = None,
    heat: HeatArrays | None = None,
    cells: FullCells | GrowingCells | None = None,
) -> Bundle:
    """Build the loop that computes new velocities of the points of a body. It also maps their momentum, for the second nodal
    velocities of MUSL.

    affine: APIC fields, shape (points, 10). heat: arrays of a body whose points store internal energy. Their energies
    receive the work dt V σ:∇v̄ with the volume, stress and shape functions of the nodal forces, where v̄ is the mean nodal
    velocity of the step along which these forces do work. They also receive the heat of the transfer if it is a loss; with
    APIC always, since its sign changes along the path of the points. cells: full cells (cells that the fluid fills), over
    which the growth rates of volumes are summed.

    Fills columns of the sums over points: kinetic energy, momentum and speed; LUMPING and LOSS, the kinetic energy lost by
    lumping and by the whole transfer; GAINED and KEPT, the energy added to the points and the heat in it; AFFINE, the
    kinetic energy of affine fields [J].
    """
    points = mapped.points
    work: Any = NoWork()
    worked: Any = ()
    kept_work: Any = ()
    if heat is not None:
        work = WorkInCells(cells.cells.full) if isinstance(cells, GrowingCells) else Work()
        worked, kept_work = Worked(points.volume, points.stress, heat.energy), heat
    elif isinstance(cells, FullCells):
        work, worked = Rates(), points.volume
    fields: Any = () if affine is None else affine
    gradient = () if isinstance(work, NoWork) else IDENTITY
    declared = Declaration(
        gathers=Gathered(ZERO_VECTOR, 0.0, 0.0, () if affine is None else (IDENTITY, 0.0), gradient),
        looks_up=affine_functions_like(transfer, mapped.functions),
        sums=(*MOTION_SUMS, *(() if heat is None else (GAINED, KEPT)), *(() if affine is None else (AFFINE,))),
    )
    read = Read(points.position, points.velocity, points.mass, fields, worked)
    kept = Kept(points.velocity, fields, kept_work)
    to_cells = ToCells(cells.sums, RATES) if isinstance(cells, FullCells) else None
    return pass_points(TakeVelocity(transfer, work), declared, mapped, read, kept, inertia_of(mapped, 0.0, affine), to_cells)
