"""How points take their velocity from the grid: FLIP, a blend of FLIP and PIC, or APIC.

Sources: Brackbill & Ruppel 1986 (FLIP); Stomakhin et al. 2013 (blend); Jiang, Schroeder & Teran 2017, J. Comput. Phys. 338, 137
(APIC). An APIC point also carries the affine velocity field C about itself, `affine` of shape (n, 9) [1/s].
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from pellucid.jit import generic, point_function


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


@generic
def new_velocity(transfer: Any, v: float, mapped: float, change: float) -> float:
    """A velocity component after the step, from the old one, the grid's new velocity, and the grid's change [m/s]."""


@generic
def affine_of(transfer: Any, affine: Any, p: int) -> Any:
    """The affine field C of point p as a 9-tuple [1/s], zero but for APIC."""


@generic
def affine_velocity(transfer: Any, v: float, C0: float, C1: float, C2: float, dx: float, dy: float, dz: float) -> float:
    """A component of the velocity that a point gives to a node at distance (dx, dy, dz) [m/s]."""


@point_function(new_velocity, Flip)
def _flip(transfer, v, mapped, change):
    return v + change


@point_function(new_velocity, Blend)
def _blend(transfer, v, mapped, change):
    return transfer.flip * (v + change) + (1.0 - transfer.flip) * mapped


@point_function(new_velocity, Apic)
def _apic(transfer, v, mapped, change):
    return mapped


@point_function(affine_of, Flip)
@point_function(affine_of, Blend)
def _no_affine(transfer, affine, p):
    return (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@point_function(affine_of, Apic)
def _affine(transfer, affine, p):
    return (
        affine[p, 0],
        affine[p, 1],
        affine[p, 2],
        affine[p, 3],
        affine[p, 4],
        affine[p, 5],
        affine[p, 6],
        affine[p, 7],
        affine[p, 8],
    )


@point_function(affine_velocity, Flip)
@point_function(affine_velocity, Blend)
def _rigid_velocity(transfer, v, C0, C1, C2, dx, dy, dz):
    return v


@point_function(affine_velocity, Apic)
def _affine_velocity(transfer, v, C0, C1, C2, dx, dy, dz):
    return v + C0 * dx + C1 * dy + C2 * dz


# by the name in the case file; each takes the case's flip fraction
TRANSFERS: dict[str, Callable[[float], VelocityTransfer]] = {
    "flip": lambda fraction: Flip(),
    "pic": lambda fraction: Blend(0.0),
    "blend": lambda fraction: Blend(fraction),
    "apic": lambda fraction: Apic(),
}
