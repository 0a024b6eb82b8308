"""Transfer of velocity from the grid to points: FLIP, a blend of FLIP and PIC, APIC, or AFLIP.

Sources: Brackbill & Ruppel 1986 (FLIP); Stomakhin et al. 2013 (blend); Jiang, Schroeder & Teran 2017, J. Comput. Phys. 338,
137 (APIC); Fei et al. 2021, ACM Trans. Graph. 40, 109 (AFLIP). With APIC and AFLIP a point also carries the affine velocity
field C around itself: nine numbers of its row of `affine`, shape (n, 10) [1/s].
"""

from collections.abc import Callable
from typing import Any, NamedTuple

from pellucid.jit import generic, point_function


class Flip(NamedTuple):
    """FLIP: the velocity of a point changes by the nodal velocity increment over a step, interpolated to the point."""

    flip: float = 1.0  # share of FLIP


class Blend(NamedTuple):
    """Blend of FLIP, with the share `flip`, and PIC (points receive the interpolated nodal velocity), with the share 1 -
    `flip`."""

    flip: float  # share of FLIP, between 0 and 1


class Apic(NamedTuple):
    """APIC: points receive the interpolated nodal velocity, and the affine velocity field C of the nodes around them. AFLIP:
    the same field, but velocities of a blend of FLIP, with the share `flip`, and PIC, with the share 1 - `flip`."""

    flip: float = 0.0  # share of FLIP, between 0 and 1; 0 with APIC


VelocityTransfer = Flip | Blend | Apic


@generic
def new_velocity(transfer: Any, v: float, mapped: float, change: float) -> float:
    """Return a velocity component of a point after the step [m/s].

    v: the component before the step; mapped: the nodal velocity after the step, interpolated to the point; change: increment
    of the nodal velocity over the step, interpolated to the point. transfer: `Flip`, `Blend` or `Apic`.
    """


@point_function(new_velocity, Flip)
def _flip(transfer, v, mapped, change):
    return v + change


@point_function(new_velocity, Blend)
@point_function(new_velocity, Apic)
def _blend(transfer, v, mapped, change):
    return transfer.flip * (v + change) + (1.0 - transfer.flip) * mapped


# by the name in the case file; each takes the case's flip fraction
TRANSFERS: dict[str, Callable[[float], VelocityTransfer]] = {
    "flip": lambda fraction: Flip(),
    "pic": lambda fraction: Blend(0.0),
    "blend": lambda fraction: Blend(fraction),
    "apic": lambda fraction: Apic(),
    "aflip": lambda fraction: Apic(fraction),
}
AFFINE = tuple(name for name, transfer in TRANSFERS.items() if isinstance(transfer(0.0), Apic))
"""Names of the transfers with affine velocity fields."""
