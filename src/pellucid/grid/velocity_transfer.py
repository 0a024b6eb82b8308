"""Transfer of velocity from the grid to points: FLIP, a blend of FLIP and PIC, or APIC.

Sources: Brackbill & Ruppel 1986 (FLIP); Stomakhin et al. 2013 (blend); Jiang, Schroeder & Teran 2017, J. Comput. Phys. 338,
137 (APIC). An APIC point also carries the affine velocity field C around itself: nine numbers of its row of `affine`, shape
(n, 10) [1/s].
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from pellucid.jit import generic, point_function


class Flip(NamedTuple):
    """FLIP: points add the velocity increment of the grid over a step to their own velocity."""

    flip: float = 1.0


class Blend(NamedTuple):
    """Blend of FLIP, with the share `flip`, and PIC, with the share 1 - `flip`."""

    flip: float


class Apic(NamedTuple):
    """APIC: points receive the grid velocity and the affine field C of the grid velocity around them."""

    flip: float = 0.0


VelocityTransfer = Flip | Blend | Apic


@generic
def new_velocity(transfer: Any, v: float, mapped: float, change: float) -> float:
    """Return a velocity component of a point after the step [m/s].

    v: the velocity of the point before; mapped: the grid velocity at the point after the step; change: its increment over the
    step.
    """


@point_function(new_velocity, Flip)
def _flip(transfer, v, mapped, change):
    return v + change


@point_function(new_velocity, Blend)
def _blend(transfer, v, mapped, change):
    return transfer.flip * (v + change) + (1.0 - transfer.flip) * mapped


@point_function(new_velocity, Apic)
def _apic(transfer, v, mapped, change):
    return mapped


# by the name in the case file; each takes the case's flip fraction
TRANSFERS: dict[str, Callable[[float], VelocityTransfer]] = {
    "flip": lambda fraction: Flip(),
    "pic": lambda fraction: Blend(0.0),
    "blend": lambda fraction: Blend(fraction),
    "apic": lambda fraction: Apic(),
}
