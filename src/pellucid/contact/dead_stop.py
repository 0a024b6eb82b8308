"""What stops two bodies of which none deforms: a damper on the mean approach of all points in contact.

It is so strong beside what both weigh there that they hardly rebound: one that is critical and may only push lets go at exp(-2)
of the speed of an impact, one of DEAD times that at 1/(2 DEAD)² in short steps. In those of a run a body comes in by up to a
step's way before anything pushes, and the spring gives some hundredths of the speed back. A step takes the approach as an
implicit one would, to 1/(1 + c A Δt) of it for the damper c and what an impulse changes of the approach, A, so that no step is
too long for it. What others push along one way too responds to each with its share of the mass.

What rolls or glides does not approach, though each of its points may: those ahead go down, those behind up, and with few points
in contact their mean goes to and fro. So where both surfaces face each other the rotation of a body counts by the velocities
along its own normals, with which it brings its surface nearer, a round one not at all; the rest, and all of a corner, whose
sides look elsewhere, by those along the normals of the other body, over which it may glide.
"""

from collections.abc import Sequence
from math import sqrt
from typing import TYPE_CHECKING

import numpy as np

from pellucid.contact.contact_surface import ContactSurface

if TYPE_CHECKING:
    from pellucid.contact.overlap import Overlap

DEAD = 8.0  # over what is critical
FACING, ASKEW = 0.97, 0.9
"""Cosines of the angle between normals that face each other, from which on they do so wholly, and down to which at all."""


class DeadStop:
    """The damper between surfaces of which these belong to rigid bodies whose motion is not all prescribed."""

    def __init__(self, rigid: Sequence[ContactSurface]) -> None:
        self._rigid = rigid
        self._now = 0.0  # mean approach [m/s]
        self.damped = self.approach = 0.0
        """Of all dampers [N], and the mean approach [m/s], as the last step began."""

    def force(
        self, overlaps: "Sequence[Overlap]", pressures: Sequence[np.ndarray], stiffness: tuple[float, float], dt: float
    ) -> float:
        """Of the damper over a step dt [s], shared out as the pressures are [N]; stiffness: now, and after
        it as it counts in the bound on the step [N/m].

        Adds to how fast the bodies swing on what they touch.
        """
        total = sum(float(pressure.sum()) for pressure in pressures)
        if total <= 0.0:
            return 0.0
        shares = [pressure / total for pressure in pressures]
        self._now = sum(float(share @ _approach(part)) for share, part in zip(shares, overlaps, strict=True))
        mobility = 0.0
        for side in self._rigid:
            place = np.concatenate([part.one.place[part.listed] for part in overlaps])
            ways = [
                (1.0 if part.one is side else -1.0) * share[:, None] * part.normal
                for share, part in zip(shares, overlaps, strict=True)
            ]
            way = np.concatenate(ways)
            own = side.mobility_along(place, way)
            mobility += _sharing(side.pushed_along, way.sum(axis=0)) * own
            side.swings += stiffness[1] * own
        if mobility <= 0.0:
            return 0.0
        damper = 2.0 * DEAD * sqrt(stiffness[0] / mobility)
        return damper * self._now / (1.0 + damper * mobility * dt)

    def taken(self, damped: float, power: float, last: float) -> float:
        """Energy that dampers took over the last step [J], which lasted so long [s]; damped, power: their force [N] and what
        they take [W] as it ends.

        The work of contact counts the mean of the velocities before and after a step: of a damper F it is that of the mean of
        the forces before and after on the velocity after, where F and v change by much in a step.
        """
        energy = 0.5 * last * (self.damped * self._now + power)
        self.damped, self.approach = damped, self._now
        return energy

    def end(self, last: float) -> float:
        """The same where nothing touches any more."""
        energy = 0.5 * last * self.damped * self.approach
        self.damped = self.approach = 0.0
        return energy


def _sharing(pushed_along: Sequence[np.ndarray], way: np.ndarray) -> float:
    """Among how many contacts a body shares its mass along a way, (3,): unit vectors along which it is pushed, (3,) each."""
    return max(1.0, float(sum((along @ way) ** 2 for along in pushed_along)) / max(float(way @ way), 1e-300))


def _approach(part: "Overlap") -> np.ndarray:
    """How fast the surfaces come nearer at each point [m/s], shape (n,)."""
    area = part.one.area[part.listed]
    own = area / np.linalg.norm(area, axis=1, keepdims=True)
    facing = np.clip((-np.einsum("ij,ij->i", own, part.normal) - ASKEW) / (FACING - ASKEW), 0.0, 1.0)
    turning = np.einsum("ij,ij->i", part.one.turning(part.one.place[part.listed]), own + part.normal)
    return np.asarray(facing * turning - np.einsum("ij,ij->i", part.relative, part.normal))
