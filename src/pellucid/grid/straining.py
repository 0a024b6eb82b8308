"""Velocity gradients at the points, and the resulting volumes, stresses and positions."""

from math import inf, sqrt
from typing import Any, NamedTuple

from pellucid.grid.passes.points_pass import Declaration, Found, at_point, gathered, looked_up, pass_points
from pellucid.grid.points import (
    DISSIPATED,
    GROWTH,
    HEATING,
    INVERTED,
    NOT_FINITE,
    POWER,
    RATE,
    SHIFT,
    STORED,
    FullCells,
    GrowingCells,
    MappedPoints,
    NoCells,
    cell_at,
)
from pellucid.grid.stencil import gather, gather_gradient, halfway
from pellucid.jit import generic, point_function, pointwise
from pellucid.jit.bundle import Bundle
from pellucid.materials.law import (
    artificial_heating,
    diffusivity,
    dissipated_energy,
    signal_speed,
    stored_energy,
    update,
    volume_growth,
)
from pellucid.tensors import IDENTITY, ZERO_VECTOR, end_stress_power


class Read(NamedTuple):
    """Input of the loop `straining` at one point, or the arrays of all points: position, velocity, mass, volume and
    material state before the step."""

    position: Any  # [m]
    velocity: Any  # [m/s]
    mass: Any  # [kg]
    volume: Any  # [m³]
    state: Any  # state of the material law, such as stress and internal variables


class Kept(NamedTuple):
    """Output of the loop `straining` at one point, or the arrays of all points: position, volume and material state after
    the step."""

    position: Any  # [m]
    volume: Any  # [m³]
    state: Any  # state of the material law


class AtPosition(NamedTuple):
    """Input of `GatherMotion` at a point: the first member of the input of every pass."""

    position: Any  # [m]


MOTION_LIKE = IDENTITY, ZERO_VECTOR
"""Example of what `GatherMotion` gathers: velocity gradient and velocity."""


class GatherMotion(NamedTuple):
    """Rule by which the velocity gradient and the velocity at a point are gathered from the nodes."""

    cells: Any  # `FullCells`, whose growth rates are added to the gradient, `GrowingCells` or `NoCells`
    curving: float  # 1 if points move with the velocity that strains them, else 0


class Strain(NamedTuple):
    """Operation at each point: computes volume and stress from the velocity gradient, and the new position if points move."""

    law: Any  # material law
    cells: Any  # `FullCells`, whose growth rates are included, `GrowingCells` or `NoCells`
    moving: float  # 1 if points move, else 0
    curving: float  # 1 if they move along curved paths, see `straining`, else 0


@generic
def lacking_growth(cells: Any, lattice: Any, place: Any) -> Any:
    """Return, for a point at `place` [m] in a full cell (a cell that the fluid fills), the relative volume growth rate that the
    points of this cell lack: growth rate of the cell minus growth rate of its points [1/s]; () without full cells. For
    `GrowingCells`, return 1.0 in a full cell, else 0.0, and the growth rate of the cell.

    cells: its type selects the implementation.
    """


@generic
def grown(cells: Any, lattice: Any, L: Any, lacking: Any) -> Any:
    """Return the velocity gradient L of a point [1/s], to which the growth rate `lacking` (result of `lacking_growth`) is
    added in equal parts along the axes that are not one cell thick; for `GrowingCells`, what makes its trace that rate.

    cells: its type selects the implementation.
    """


@point_function(lacking_growth, NoCells)
def _lacks_nothing(cells, lattice, place):
    return ()


@point_function(lacking_growth, FullCells)
def _lacks(cells, lattice, place):
    return cells.found[cell_at(lattice, place), SHIFT]


@point_function(lacking_growth, GrowingCells)
def _grows(cells, lattice, place):
    cell = cell_at(lattice, place)
    return 1.0 if cells.cells.full[cell] else 0.0, cells.cells.found[cell, GROWTH]


@point_function(grown, NoCells)
def _as_it_is(cells, lattice, L, lacking):
    return L


@point_function(grown, GrowingCells)
def _as_the_cell(cells, lattice, L, lacking):
    full, growth = lacking
    return _with_more(lattice, L, full * (growth - (L[0] + L[4] + L[8])))


@point_function(grown, FullCells)
def _grown(cells, lattice, L, lacking):
    return _with_more(lattice, L, lacking)


@pointwise
def _with_more(lattice, L, growth):
    """Return the velocity gradient L [1/s], to which a growth rate [1/s] is added in equal parts along the axes that are not
    one cell thick."""
    n = lattice.counts
    x, y, z = 1.0 if n[0] > 1 else 0.0, 1.0 if n[1] > 1 else 0.0, 1.0 if n[2] > 1 else 0.0
    more = 1.0 / (x + y + z) * growth
    return L[0] + x * more, L[1], L[2], L[3], L[4] + y * more, L[5], L[6], L[7], L[8] + z * more


@point_function(looked_up, GatherMotion)
def _look_up(rule, lattice, functions, about, p):
    return lacking_growth(rule.cells, lattice, p.position)


@point_function(gathered, GatherMotion)
def _motion(rule, about, lattice, nodes, p, known):
    moving = nodes.strain_velocity if rule.curving > 0.0 else nodes.velocity
    return gather_gradient(about, lattice, nodes.strain_velocity), gather(about, lattice, moving)


@point_function(at_point, Strain)
def _strain(task, lattice, dt, p, known, g):
    law, h, m, v, (L, u), step = task.law, lattice.inverse_cell, p.mass, p.velocity, g, task.moving * dt
    half, at_nodes = 0.5 * dt * task.curving, L
    L = grown(task.cells, lattice, L, known)
    growth = volume_growth(law, L, dt)
    V = growth * p.volume
    density = m / V
    state = update(law, p.state, density, L, dt, lattice.cell)
    energy, signal = stored_energy(law, state, density), signal_speed(law, state, density, L, lattice.cell)
    speed = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2])
    magnitude = abs(energy + state.stress[0] + state.stress[1] + state.stress[2] + speed + signal)
    fault = 0.0 if magnitude < inf and growth > 0.0 else float(NOT_FINITE)
    fault = float(INVERTED) if growth <= 0.0 else fault
    rate, viscous = h * (signal + speed), 2.0 * h * h * diffusivity(law, density)
    sums = (
        m * energy,
        m * dissipated_energy(law, state, density),
        V * end_stress_power(state.stress, L, dt),
        m * artificial_heating(law, state, density, L, lattice.cell),
    )
    u = halfway(half, at_nodes, u)
    place = p.position[0] + step * u[0], p.position[1] + step * u[1], p.position[2] + step * u[2]
    return Found(Kept(place, V, state), sums, rate if rate > viscous else viscous, fault)


def straining(
    law: Any,
    mapped: MappedPoints,
    state: Any,
    cells: FullCells | GrowingCells | None = None,
    moving: bool = True,
    curving: bool = False,
) -> Bundle:
    """Build the loop over the points of a body that computes their velocity gradients, and from these new volumes and stresses.

    law: material law; state: its state arrays; cells: full cells (cells that the fluid fills) with a mean
    pressure; moving:
    True if points also move; curving: True if they move with the velocity u + ½Δt L u, for the nodal velocity u that strains
    them and its gradient L, so that points of a steady flow stay on its curved paths to second order. Fills the columns STORED,
    DISSIPATED, HEATING, POWER and RATE of the sums over points. mapped: the points.
    """
    points = mapped.points
    full: Any = NoCells() if cells is None else cells
    declared = Declaration(
        gathers=MOTION_LIKE,
        looks_up={NoCells: (), FullCells: 0.0, GrowingCells: (0.0, 0.0)}[type(full)],
        rule=GatherMotion(full, float(curving)),
        rule_reads=AtPosition(ZERO_VECTOR),
        sums=(STORED, DISSIPATED, POWER, HEATING),
        largest=RATE,
        places=True,
    )
    read = Read(points.position, points.velocity, points.mass, points.volume, state)
    kept = Kept(points.position, points.volume, state)
    return pass_points(Strain(law, full, float(moving), float(curving)), declared, mapped, read, kept)
