"""The forces of an overlap: pressure, damping and friction on points of a surface that lie in another body.

See `pellucid.contact.surface_pairs` for what they are and why.
"""

from collections.abc import Mapping, Sequence
from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.contact.contact_energy import Held, taken_by_friction
from pellucid.contact.contact_surface import ContactSurface

STIFF, DAMPING = 1.0, 0.1
"""How fast the layer of a body that touches swings, over its step: from two on it would go out of bounds. What the damper takes
of what is critical for the masses of the layers."""
SINK, IMPACT = 3e-4, 0.2
"""Cells: how far a rigid body sinks into another that does not deform either, lying with all of its side on it, and striking it
so with the speeds of the start."""
RESOLVED = (
    0.3  # over how fast a rigid body swings then: its step, whatever `time.courant` is. In a longer one it comes too deep
)
# before anything pushes, and the damper throws it back
STICKS = 1e12  # coefficient of friction of what sticks while it presses


class Overlap(NamedTuple):
    """n points of a surface that lie in another body."""

    one: ContactSurface
    listed: np.ndarray  # (n,) which of its points
    depth: np.ndarray  # (n,) [m]
    normal: np.ndarray  # (n, 3) of the other body, outwards
    area: np.ndarray  # (n,) by which each counts [m²]
    relative: np.ndarray  # (n, 3) velocity against the other body [m/s]
    share: float = 1.0  # of the stiffness


class OverlapLaw:
    """What the points in an overlap feel.

    sides: the surfaces that touch; one alone where the other body neither deforms nor gives way, as a wall. friction:
    coefficient μ, `STICKS` where they stick while they press. courant: of the case's `time`. swing: how fast bodies that do not
    deform are to swing on each other [1/s], see `swing_of`; 0 where nothing moves them, and their materials tell.
    """

    def __init__(self, sides: Sequence[ContactSurface], friction: float, courant: float, swing: float = 0.0) -> None:
        self._friction = friction
        self._hard = all(side.is_hard for side in sides)
        self._mass = 1.0 / max(sum(1.0 / side.rigid_mass for side in sides), 1e-300)
        soft = [side for side in sides if self._hard or not side.is_hard]
        rates = [side.rate * (STIFF / courant if side.follows_steps else 1.0) for side in soft]
        self.stiffness = 1.0 / sum(1.0 / (side.mass_per_area * rate**2) for side, rate in zip(soft, rates, strict=True))
        """κ [Pa/m]."""
        rigid = [side for side in sides if side.rigid_mass < np.inf]
        if self._hard and rigid and swing > 0.0:
            self.stiffness = swing**2 * self._mass / max(side.side() for side in rigid)
        self._damping = 2.0 * DAMPING * sqrt(self.stiffness / sum(1.0 / side.mass_per_area for side in soft))
        for side in rigid:
            swings = sqrt(self.stiffness * side.side() / self._mass)
            side.contact_rate = max(side.contact_rate, courant / RESOLVED * swings)
        self._rigid = len(rigid) > 0
        self.held = Held()
        """Energy of the overlaps that were asked for last."""

    def forces(self, overlaps: Sequence[Overlap], last: float, touched: Mapping[int, np.ndarray]) -> list[np.ndarray]:
        """Forces on the points of each overlap [N], shape (n, 3); last: length of the step before [s].

        touched: of the points of each surface, by its identity, shape (m,): those that friction holds are marked.
        """
        pressures = [part.share * self.stiffness * part.area * part.depth for part in overlaps]
        extra = self._mean_damping(overlaps, pressures) if self._hard and self._rigid else 0.0
        total = sum(float(pressure.sum()) for pressure in pressures)
        stored = taken = pending = 0.0
        found = []
        for part, pressure in zip(overlaps, pressures, strict=True):
            n = part.normal
            approach = -np.einsum("ij,ij->i", part.relative, n)
            damping = part.share * self._damping * part.area
            press = np.maximum(pressure + damping * approach + extra * pressure / total, 0.0)
            force = press[:, None] * n
            stored += 0.5 * float(np.sum(pressure * part.depth))
            taken += last * float(np.sum((press - pressure) * approach))
            if self._friction > 0.0:
                along = part.relative + approach[:, None] * n
                drag, lost = self._drag(part, along, self._friction * press, damping, last)
                force += drag
                taken += lost
                touched[id(part.one)][part.listed] = True
            pending += 0.5 * last * float(np.sum(force * part.relative))
            found.append(force)
        self.held = Held(stored, taken, pending)
        return found

    def _drag(
        self, part: Overlap, along: np.ndarray, most: np.ndarray, damping: np.ndarray, last: float
    ) -> tuple[np.ndarray, float]:
        """Friction of points with velocities along the other body [m/s], shape (n, 3), at most so much [N], shape (n,); the
        energy that it took since the last step [J]."""
        one, n, at = part.one, part.normal, part.listed
        if one.drag is not None:
            drag, _ = _limited(-one.drag[at][:, None] * along, most)
            return drag, -last * float(np.sum(drag * along))
        before = one.slip[at]
        carried = before - np.einsum("ij,ij->i", before, n)[:, None] * n + last * along
        spring = part.share * self.stiffness * part.area
        drag, slides = _limited(-spring[:, None] * carried - damping[:, None] * along, most)
        one.slip[at] = np.where(slides[:, None], _held(carried, spring, most), carried)
        damped = last * damping * np.sum(along * along, axis=1)
        return drag, taken_by_friction(spring, before, carried, drag, last * along, damped, slides)

    def _mean_damping(self, overlaps: Sequence[Overlap], pressures: Sequence[np.ndarray]) -> float:
        """The force of the second damper, by the mean approach under these pressures [N]."""
        approach = stiffness = total = 0.0
        for part, pressure in zip(overlaps, pressures, strict=True):
            total += float(pressure.sum())
            approach -= float(np.sum(pressure * np.einsum("ij,ij->i", part.relative, part.normal)))
            stiffness += part.share * self.stiffness * float(part.area.sum())
        return 2.0 * sqrt(stiffness * self._mass) * approach / total if total > 0.0 else 0.0


def _limited(drag: np.ndarray, most: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Forces, shape (n, 3), none larger than most, shape (n,), and which are limited."""
    size = np.linalg.norm(drag, axis=1)
    slides = size > most
    drag[slides] *= (most[slides] / size[slides])[:, None]
    return drag, slides


def _held(carried: np.ndarray, spring: np.ndarray, most: np.ndarray) -> np.ndarray:
    """What a spring keeps of how far it was carried where its force is limited."""
    size = np.linalg.norm(carried, axis=1)
    longest = np.where(spring > 0.0, most / np.where(spring > 0.0, spring, 1.0), 0.0)
    return np.asarray(carried * np.minimum(1.0, longest / np.maximum(size, 1e-300))[:, None])


def coefficient(kind: str, friction: float | None) -> float:
    """The coefficient μ of a kind of contact, `frictionless`, `stick` or `coulomb`."""
    return STICKS if kind == "stick" else friction or 0.0


def swing_of(cell: float, gravity: float, speed: float) -> float:
    """How fast bodies that do not deform are to swing on each other [1/s], for cells [m], gravity [m/s²] and speeds [m/s]."""
    return max(sqrt(gravity / (SINK * cell)), speed / (IMPACT * cell))
