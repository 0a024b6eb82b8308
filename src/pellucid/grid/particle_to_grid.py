"""Particle to grid (P2G): momentum, mass and internal forces of points, in the nodal rows `inertia` and `forces`."""

from typing import Any, NamedTuple

import numpy as np

from pellucid.grid.passes.gifts import (
    FIRST,
    SECOND,
    Both,
    BySlope,
    ByValue,
    by_slope,
    by_value,
    given,
    giving,
    row_of_node,
    rows_at_nodes,
    rows_of_line,
    scatter,
)
from pellucid.grid.passes.points_pass import arrays_in
from pellucid.grid.points import PRESSURE, FullCells, GrowingCells, MappedPoints, cell_of, pressure_of
from pellucid.jit import point_function, pointwise
from pellucid.jit.columns import moved
from pellucid.jit.rows import symmetric_at_point, tensor_at_point, vector_at_point
from pellucid.jit.vector import row


class Inertia(NamedTuple):
    """Contribution of a point to the nodes: its momentum m v [kg m/s], and its mass [kg] if `with_mass` is 1 instead of 0."""

    with_mass: float


class AffineInertia(NamedTuple):
    """Contribution of a point to the nodal momentum, m (v + C r) [kg m/s], with the mass m and velocity v of the point and
    its affine velocity field C at a node at the distance r, and its mass [kg] if `with_mass` is 1 instead of 0."""

    with_mass: float


class InertiaRead(NamedTuple):
    """Mass, velocity and affine field of a point, from which its contribution to nodal mass and momentum is computed, or the
    arrays of all points."""

    velocity: np.ndarray  # (n, 3) [m/s]
    mass: np.ndarray  # (n,) [kg]
    affine: Any  # (n, 10) affine fields [1/s] and their energies, or () for points without affine fields


class InternalForce(NamedTuple):
    """Contribution -V σ ∇N of a point to the nodal forces [N], with its volume V and stress σ."""


class InternalForceInCells(NamedTuple):
    """Contribution -V (σ + p I) ∇N [N] of a point with the volume V and stress σ in a full cell (a cell that the fluid
    fills) to the nodal forces. The forces of the mean pressure p of the cell are added separately, see
    `pellucid.grid.full_cells`."""

    found: np.ndarray  # see `FullCells`


class InternalForceWithoutPressure(NamedTuple):
    """Contribution -V σ' ∇N of a point to the nodal forces [N], with its volume V and stress σ; in a full cell (a cell that the
    fluid fills), σ' is σ without its mean, since the forces of the pressure of the cell are added separately, see
    `pellucid.grid.full_cells`."""

    full: np.ndarray  # see `FullCells`


class InternalForceRead(NamedTuple):
    """Volume, stress and position of a point, from which its contribution to the nodal forces is computed, or the arrays of all
    points."""

    volume: np.ndarray  # (n,) [m³]
    stress: np.ndarray  # (n, 6) [Pa]
    position: Any  # (n, 3) [m], or () without full cells


@point_function(given, Inertia)
def _inertia(rule, lattice, points, p):
    return points.mass[p] * (vector_at_point(points.velocity, p) + row(0.0, 0.0, 0.0, rule.with_mass))


@point_function(given, AffineInertia)
def _affine_inertia(rule, lattice, points, p):
    m, (x, y, z) = points.mass[p], tensor_at_point(points.affine, p)
    of_momentum = row(m, m, m, 0.0)
    at_place = m * (vector_at_point(points.velocity, p) + row(0.0, 0.0, 0.0, rule.with_mass))
    return at_place, of_momentum * x, of_momentum * y, of_momentum * z


@point_function(rows_at_nodes, AffineInertia)
def _by_distance(rule, rows, about, cell):
    x, y, z = cell * rows[1], cell * rows[2], cell * rows[3]
    first = rows[0] + about.offset[0] * x + about.offset[1] * y + about.offset[2] * z
    return moved(moved(moved((first,), about.wz, z), about.wy, y), about.wx, x)


@point_function(rows_of_line, AffineInertia)
def _affine_line(rule, rows, w, dx, dy):
    return w * (rows[0] + dx * rows[1] + dy * rows[2]), w * rows[3]


@point_function(row_of_node, AffineInertia)
def _affine_node(rule, line, dz):
    return line[0] + dz * line[1]


@pointwise
def _times_volume(V, x, y, z):
    """Return the columns x, y, z of the stress [Pa] of a point, multiplied by -V with its volume V [m³]."""
    taken = row(-V, -V, -V, 0.0)
    return taken * x, taken * y, taken * z


@point_function(given, InternalForce)
def _internal_force(rule, lattice, points, p):
    x, y, z = symmetric_at_point(points.stress, p)
    return _times_volume(points.volume[p], x, y, z)


@pointwise
def _with_pressure(points, p, pressure):
    """Return the columns of the stress of point p plus a pressure [Pa], multiplied by -V with its volume V [m³]."""
    x, y, z = symmetric_at_point(points.stress, p)
    x += row(pressure, 0.0, 0.0, 0.0)
    y += row(0.0, pressure, 0.0, 0.0)
    z += row(0.0, 0.0, pressure, 0.0)
    return _times_volume(points.volume[p], x, y, z)


@point_function(given, InternalForceInCells)
def _internal_force_in_cells(rule, lattice, points, p):
    return _with_pressure(points, p, rule.found[cell_of(lattice, points.position, p), PRESSURE])


@point_function(given, InternalForceWithoutPressure)
def _internal_force_without_pressure(rule, lattice, points, p):
    full = rule.full[cell_of(lattice, points.position, p)]
    return _with_pressure(points, p, pressure_of(points.stress, p) if full else 0.0)


def inertia_of(mapped: MappedPoints, with_mass: float, affine: np.ndarray | None = None) -> ByValue:
    """Return the P2G contribution of the momentum of a body's points to the nodal rows `inertia`.

    with_mass: 1 to add their masses, else 0; affine: affine fields of APIC, shape (points, 10), or None. mapped: the points.
    """
    read = InertiaRead(mapped.points.velocity, mapped.points.mass, () if affine is None else affine)
    rule = Inertia(with_mass) if affine is None else AffineInertia(with_mass)
    return by_value(rule, read, mapped.nodes.inertia)


def internal_force_of(mapped: MappedPoints, cells: FullCells | GrowingCells | None = None) -> BySlope:
    """Return the P2G contribution of the internal forces of a body's points to the nodal rows `forces`; cells: full cells
    (cells that the fluid fills), whose mean pressure acts separately; mapped: the points."""
    read = InternalForceRead(mapped.points.volume, mapped.points.stress, () if cells is None else mapped.points.position)
    rule: Any = InternalForce()
    if isinstance(cells, GrowingCells):
        rule = InternalForceWithoutPressure(cells.cells.full)
    elif cells is not None:
        rule = InternalForceInCells(cells.found)
    return by_slope(rule, read, mapped.nodes.forces)


class ParticleToGrid:
    """P2G of a body: maps mass, momentum and internal forces of its points to the nodes. affine, cells: see `inertia_of` and
    `internal_force_of`."""

    def __init__(
        self, mapped: MappedPoints, affine: np.ndarray | None = None, cells: FullCells | GrowingCells | None = None
    ) -> None:
        force = internal_force_of(mapped, cells)
        self._both = giving(mapped, Both(inertia_of(mapped, 1.0, affine), force))
        self._momentum = giving(mapped, Both(inertia_of(mapped, 0.0, affine), force))  # the same kernel gives it

    def scatter(self, inertia: bool, force: bool) -> None:
        """Map mass and momentum (if `inertia`) and internal forces -Σ V σ ∇N (if `force`) to the nodes."""
        scatter(self._both, FIRST * inertia + SECOND * force)

    def read(self) -> list[np.ndarray]:
        """Return the point arrays that the P2G reads: positions and input of the contributions."""
        return arrays_in((self._both.mapped.points.position, self._both.gives.first.read, self._both.gives.second.read))

    def scatter_momentum(self) -> None:
        """Map the momentum of the points to the nodes again, without masses, after their velocities changed (MUSL)."""
        scatter(self._momentum)
