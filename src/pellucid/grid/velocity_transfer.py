"""How points take their velocity from the grid: FLIP, a blend of FLIP and PIC, or APIC.

Sources: Brackbill & Ruppel 1986 (FLIP); Stomakhin et al. 2013 (blend); Jiang, Schroeder & Teran 2017, J. Comput. Phys. 338, 137
(APIC). An APIC point also carries the affine velocity field C about itself: nine numbers of its row of `affine`, shape
(n, 10) [1/s].
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from pellucid.jit import generic, point_function
from pellucid.jit.point_rows import tensor_at_point
from pellucid.jit.vector import row


class Flip(NamedTuple):
    """Points keep their velocity and take the grid's change of it."""

    flip: float = 1.0


class Blend(NamedTuple):
    """`flip` of FLIP and 1 - flip of PIC."""

    flip: float


class Apic(NamedTuple):
    """Points take the grid's velocity and its affine field."""

    flip: float = 0.0


VelocityTransfer = Flip | Blend | Apic

OLD, MASS, NEW, BY_LUMPING, HEAT = 0, 3, 4, 7, 8
"""Columns of a block of points: velocity before the step, mass, velocity after the step, heats of unit mass, by lumping and in
all."""


@generic
def new_velocity(transfer: Any, v: float, mapped: float, change: float) -> float:
    """A velocity component after the step, from the old one, the grid's new velocity, and the grid's change [m/s]."""


@generic
def inertia_rows(transfer: Any, m: float, v: Any, affine: Any, p: int, counted: float) -> Any:
    """What point p of mass m [kg] and velocity v [m/s], a row of four, gives to nodes, as rows of momentum x, y, z [kg m/s] and
    mass: at its place and, for APIC, by distance along x, y, z. The mass is taken `counted` times, 0 or 1."""


@generic
def rows_of_line(transfer: Any, rows: Any, w: float, dx: float, dy: float) -> Any:
    """Of that, the share w that a line of nodes along z gets at these distances [m]."""


@generic
def row_of_node(transfer: Any, line: Any, dz: float) -> Any:
    """Of that of its line, the row for a node at the distance dz [m]."""


@point_function(new_velocity, Flip)
def _flip(transfer, v, mapped, change):
    return v + change


@point_function(new_velocity, Blend)
def _blend(transfer, v, mapped, change):
    return transfer.flip * (v + change) + (1.0 - transfer.flip) * mapped


@point_function(new_velocity, Apic)
def _apic(transfer, v, mapped, change):
    return mapped


@point_function(inertia_rows, Flip)
@point_function(inertia_rows, Blend)
def _rigid_rows(transfer, m, v, affine, p, counted):
    return m * (v + row(0.0, 0.0, 0.0, counted))


@point_function(rows_of_line, Flip)
@point_function(rows_of_line, Blend)
def _rigid_line(transfer, rows, w, dx, dy):
    return w * rows


@point_function(row_of_node, Flip)
@point_function(row_of_node, Blend)
def _rigid_node(transfer, line, dz):
    return line


@point_function(inertia_rows, Apic)
def _affine_rows(transfer, m, v, affine, p, counted):
    x, y, z = tensor_at_point(affine, p)
    of_momentum = row(m, m, m, 0.0)
    return m * (v + row(0.0, 0.0, 0.0, counted)), of_momentum * x, of_momentum * y, of_momentum * z


@point_function(rows_of_line, Apic)
def _affine_line(transfer, rows, w, dx, dy):
    return w * (rows[0] + dx * rows[1] + dy * rows[2]), w * rows[3]


@point_function(row_of_node, Apic)
def _affine_node(transfer, line, dz):
    return line[0] + dz * line[1]


# by the name in the case file; each takes the case's flip fraction
TRANSFERS: dict[str, Callable[[float], VelocityTransfer]] = {
    "flip": lambda fraction: Flip(),
    "pic": lambda fraction: Blend(0.0),
    "blend": lambda fraction: Blend(fraction),
    "apic": lambda fraction: Apic(),
}
