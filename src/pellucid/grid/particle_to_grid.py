"""Particle to grid: momentum, mass and internal forces of points, into the nodes' rows `inertia` and `forces`."""

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
from pellucid.grid.points import PRESSURE, FullCells, MappedPoints, cell_of
from pellucid.jit import point_function
from pellucid.jit.point_rows import symmetric_at_point, tensor_at_point, vector_at_point
from pellucid.jit.products import moved
from pellucid.jit.vector import row


class Inertia(NamedTuple):
    """Momentum m v [kg m/s], and mass [kg] `counted` times, 0 or 1."""

    counted: float


class AffineInertia(NamedTuple):
    """The same of points with affine velocity fields: m (v + C r) at the distance r."""

    counted: float


class InertiaRead(NamedTuple):
    """What it reads."""

    velocity: np.ndarray  # (n, 3)
    mass: np.ndarray  # (n,)
    affine: Any  # (n, 10), or () of points without such fields


class InternalForce(NamedTuple):
    """-V σ ∇N [N]."""

    none: int = 0


class InternalForceInCells(NamedTuple):
    """The same without the pressure of full cells, which acts there as a whole."""

    found: np.ndarray  # as `FullCells` has it


class InternalForceRead(NamedTuple):
    """What it reads."""

    volume: np.ndarray  # (n,)
    stress: np.ndarray  # (n, 6)
    position: Any  # (n, 3), or () where cells do not matter


@point_function(given, Inertia)
def _inertia(give, lattice, points, p):
    return points.mass[p] * (vector_at_point(points.velocity, p) + row(0.0, 0.0, 0.0, give.counted))


@point_function(given, AffineInertia)
def _affine_inertia(give, lattice, points, p):
    m, (x, y, z) = points.mass[p], tensor_at_point(points.affine, p)
    of_momentum = row(m, m, m, 0.0)
    at_place = m * (vector_at_point(points.velocity, p) + row(0.0, 0.0, 0.0, give.counted))
    return at_place, of_momentum * x, of_momentum * y, of_momentum * z


@point_function(rows_at_nodes, AffineInertia)
def _by_distance(give, rows, about, cell):
    x, y, z = cell * rows[1], cell * rows[2], cell * rows[3]
    first = rows[0] + about.offset[0] * x + about.offset[1] * y + about.offset[2] * z
    return moved(moved(moved((first,), about.wz, z), about.wy, y), about.wx, x)


@point_function(rows_of_line, AffineInertia)
def _affine_line(give, rows, w, dx, dy):
    return w * (rows[0] + dx * rows[1] + dy * rows[2]), w * rows[3]


@point_function(row_of_node, AffineInertia)
def _affine_node(give, line, dz):
    return line[0] + dz * line[1]


@point_function(given, InternalForce)
def _internal_force(give, lattice, points, p):
    xx, yy, zz = symmetric_at_point(points.stress, p)
    V = -points.volume[p]
    taken = row(V, V, V, 0.0)
    return taken * xx, taken * yy, taken * zz


@point_function(given, InternalForceInCells)
def _internal_force_in_cells(give, lattice, points, p):
    xx, yy, zz = symmetric_at_point(points.stress, p)
    pressure = give.found[cell_of(lattice, points.position, p), PRESSURE]
    xx += row(pressure, 0.0, 0.0, 0.0)
    yy += row(0.0, pressure, 0.0, 0.0)
    zz += row(0.0, 0.0, pressure, 0.0)
    V = -points.volume[p]
    taken = row(V, V, V, 0.0)
    return taken * xx, taken * yy, taken * zz


def inertia_of(mapped: MappedPoints, counted: float, affine: np.ndarray | None = None) -> ByValue:
    """Momentum of points, and their masses as often as `counted`; affine: their fields, shape (points, 10)."""
    read = InertiaRead(mapped.points.velocity, mapped.points.mass, () if affine is None else affine)
    rule = Inertia(counted) if affine is None else AffineInertia(counted)
    return by_value(rule, read, mapped.nodes.inertia)


def internal_force_of(mapped: MappedPoints, cells: FullCells | None = None) -> BySlope:
    """Internal forces of points; cells: those whose pressure acts as a whole."""
    read = InternalForceRead(mapped.points.volume, mapped.points.stress, () if cells is None else mapped.points.position)
    rule = InternalForce() if cells is None else InternalForceInCells(cells.found)
    return by_slope(rule, read, mapped.nodes.forces)


class ParticleToGrid:
    """What the points of a body give to the nodes of its velocity field."""

    def __init__(self, mapped: MappedPoints, affine: np.ndarray | None = None, cells: FullCells | None = None) -> None:
        self._n_slabs = len(mapped.slabs.layers)
        self._both = giving(mapped, Both(inertia_of(mapped, 1.0, affine), internal_force_of(mapped, cells)))
        self._momentum = giving(mapped, inertia_of(mapped, 0.0, affine))

    def scatter(self, inertia: bool, force: bool) -> None:
        """Map mass and momentum (where `inertia`) and internal forces -Σ V σ ∇N (where `force`) to the nodes."""
        scatter(self._n_slabs, self._both, FIRST * inertia + SECOND * force)

    def read(self) -> list[np.ndarray]:
        """The arrays of points that both gifts read."""
        return arrays_in((self._both.mapped.points.position, self._both.gives.first.read, self._both.gives.second.read))

    def scatter_momentum(self) -> None:
        """Momentum alone, after the velocities of the points were changed (MUSL)."""
        scatter(self._n_slabs, self._momentum, FIRST)
