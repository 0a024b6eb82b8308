"""The forces of an overlap: pressure, damping and friction on points of a surface that lie in another body.

See `pellucid.contact.surface_pairs` for what they are and why.
"""

from collections.abc import Mapping, Sequence
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from pellucid.contact.contact_energy import Held, taken_by_friction
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.dead_stop import DeadStop
from pellucid.contact.point_forces import (
    ENTERED,
    LOST,
    N_LAW,
    N_SUMS,
    NOW,
    PENDING,
    POWER,
    RUBBED,
    STEADY,
    STORED,
    TINY,
    find_point_forces,
)

DAMPING, ROOM, LEAST_ROOM = 0.1, 0.9, 0.3
"""Damping ratio for the masses of the layers that touch. Part of what central differences allow that springs and dampers of
contact may use besides the waves of the body, see `_stiff`."""
SHEET_STIFF, SHEET_DAMPING = 0.5, 1.0
"""ω Δt and damping ratio where a membrane that deforms touches: its nodes do not rebound. With a critical damper, which acts by
the velocities of the step before, a step is stable up to ω Δt = 0.83."""
SINK, IMPACT = 3e-4, 0.2
"""Cells: how far a rigid body sinks into another that does not deform either, lying with all of its side on it, and striking it
so with the speeds of the start."""
RESOLVED = 0.3
"""Over how fast a rigid body swings on what it touches: its step, whatever `time.courant` is. In a longer one it comes too deep
before anything pushes, and is thrown back."""
HARDENS = 0.05
"""Cells: a depth to which two bodies that do not deform are pressed by more than their own weights, from where on they give way
less and less: by what lies on them, by loads."""
STIFFER = 4.0
"""Times at most that friction between such bodies is stiffer than their overlap: it then swings twice as fast as they do."""
OUT = 10
"""Steps during which surfaces must be further apart before this reduces an overlap of the start."""
ROUNDED = 1e-6  # of its limit, by which the drag of what slides may be off it
ROUNDED_START = 1e-9  # of a length of the mesh: depth at the start that is rounding
IMPLICIT, IMPLICIT_SHEETS = 25.0, 100.0
"""Rate of a body on implicit normal forces over its own rate, as far as the step is small enough for that; of a sheet, which is
thin against the way of its nodes in a step."""
STICKS = 1e12  # coefficient of friction of what sticks while it presses
NONE, NOT_NEW, NO_FORCES = np.zeros(0), np.zeros(0, bool), np.zeros((2, 0))


class Overlap(NamedTuple):
    """n points of a surface that lie in another body."""

    one: ContactSurface
    listed: np.ndarray  # (n,) which of its points
    depth: np.ndarray  # (n,) [m]
    normal: np.ndarray  # (n, 3) of the other body, outwards
    area: np.ndarray  # (n,) by which each counts [m²]
    relative: np.ndarray  # (n, 3) velocity against the other body [m/s]
    share: float = 1.0  # of the stiffness
    apart: bool = False  # whether each point stops by itself: a flat side on a plane
    new: np.ndarray | None = None  # (n,) whether each did not overlap in the step before; of sheets and
    # implicit normal forces alone


class Implicit(NamedTuple):
    """Implicit normal forces of n points over a step."""

    press: np.ndarray  # (n,) [N]
    after: np.ndarray  # (n,) depths at the end of the step [m]


class StartOverlap:
    """Overlap of the start, which exerts no pressure.

    It is the largest depth of the start, and is subtracted from the depths of all points: the surfaces begin in touch, as if
    they were thinner by this depth, and contact acts this much later. It decreases to the largest depth of the last `OUT` steps
    as the surfaces come apart: a point beside a curved surface may not be found for a step, and would be thrown off by all its
    depth in the next. Since nothing presses then, the energy of the rest of the depths remains one of the places alone.

    Parameters
    ----------
    length
        Distance between the points of a surface or more [m], of which `ROUNDED_START` counts as no depth.
    """

    def __init__(self, length: float) -> None:
        self._rounding, self.depth, self._begun = ROUNDED_START * length, 0.0, False
        self._recent: list[float] = []  # largest depths of the last steps
        self._by_equilibria = False

    def skip(self) -> None:
        """Apply all overlaps from the start: the surfaces touched in an earlier run."""
        self._begun = True

    def reduce(self, depth: np.ndarray) -> np.ndarray:
        """Return the depths [m] of all points near the other surface, shape (n,), without that part."""
        if self._begun and self.depth == 0.0:
            return depth
        deepest = float(depth.max(initial=0.0))
        if self._begun and self._by_equilibria:
            self._recent = [deepest]
            return depth - self.depth
        self._recent = [*self._recent[1 - OUT :], deepest]
        self.depth = min(self.depth, max(self._recent)) if self._begun else deepest
        self._begun = True
        if self.depth <= self._rounding:
            self.depth = 0.0
            return depth
        return depth - self.depth

    def begin_steady(self) -> None:
        """Change with equilibria alone from now on."""
        self._by_equilibria = True

    def reach_equilibrium(self) -> None:
        """Keep what is left of the overlap in this equilibrium."""
        if self._by_equilibria and self._begun and self.depth > 0.0:
            self.depth = min(self.depth, self._recent[-1])
            if self.depth <= self._rounding:
                self.depth = 0.0

    def state_numbers(self) -> list[object]:
        """Return the state for a checkpoint."""
        return [self._begun, self.depth, self._recent]

    def restore(self, numbers: Sequence[Any]) -> None:
        """Restore a checkpoint."""
        self._begun, self.depth, recent = numbers
        self._recent = list(recent)


class OverlapLaw:
    """Law of the forces on points in an overlap.

    sides: surfaces in contact; one only if the other body neither deforms nor yields, e.g. a wall. friction: coefficient μ,
    `STICKS` for no sliding. courant: of the case's `time`. swing: target oscillation rate of bodies that do not deform
    [1/s], see `swing_of`; 0 if nothing moves them and their materials define it. cell: edge of the cells [m]. step: fixed
    step of the case [s], 0 if `courant` sets it.
    """

    def __init__(
        self,
        sides: Sequence[ContactSurface],
        friction: float,
        courant: float,
        swing: float = 0.0,
        cell: float = np.inf,
        step: float = 0.0,
    ) -> None:
        self._friction = friction
        self._hard = all(side.is_hard for side in sides)
        self._mass = 1.0 / max(sum(1.0 / side.rigid_mass for side in sides), TINY)
        soft = [side for side in sides if self._hard or not side.is_hard]
        with_sheet = any(side.is_sheet for side in soft)
        damping = SHEET_DAMPING if with_sheet else DAMPING
        rates = [side.rate for side in soft]
        harder = IMPLICIT_SHEETS if with_sheet else IMPLICIT
        self._implicit = harder**2 / sum(1.0 / (side.mass_per_area * side.rate**2) for side in soft)
        for i, side in enumerate(soft):
            if side.follows_steps:
                part = step * side.rate if step > 0.0 else courant
                rates[i] *= (SHEET_STIFF if with_sheet else _stiff(part)) / part
        self.stiffness = 1.0 / sum(1.0 / (side.mass_per_area * rate**2) for side, rate in zip(soft, rates, strict=True))
        """κ [Pa/m]."""
        self.is_implicit = not self._hard and all(side.response is not None for side in soft)
        """Whether normal forces are implicit in the step, see `pellucid.contact.implicit`."""
        self.lost = 0.0
        """Energy that implicit forces of the last step take, without their power at the end of it [J]."""
        rigid = [side for side in sides if side.rigid_mass < np.inf]
        by_edges = self._hard and stop_apart(*sides)
        areas = {id(side): side.bearing_area() if by_edges else side.side() for side in rigid}
        if self._hard and rigid and swing > 0.0:
            self.stiffness = swing**2 * self._mass / max(areas.values())
        lightness = sum(1.0 / side.mass_per_area for side in soft)
        if with_sheet:  # a free rigid body that is lighter than the part of the sheet on it gives way too
            of_rigid = sum(areas[id(side)] / side.rigid_mass for side in rigid)
            self.stiffness *= lightness / (lightness + of_rigid)
            lightness += of_rigid
        self._damping = 2.0 * damping * sqrt(self.stiffness / lightness)
        self.stop = DeadStop(sides) if self._hard and rigid else None
        self._softness = 1.0 / (HARDENS * cell) ** 2 if self.stop else 0.0
        self._followed = courant / RESOLVED
        for side in rigid:
            swings = sqrt(self.stiffness * areas[id(side)] / self._mass)
            side.least_rate = max(side.least_rate, self._followed * swings)
        self.held = Held()
        """Energy of the overlaps that were asked for last."""
        self.counts_both_ends = self.stop is None and all(side.drag is None for side in sides)
        """Whether the energy that dampers and friction take counts their forces at both ends of a step."""
        self.given: list[np.ndarray] = []
        """Forces of dampers and friction on the points of each overlap, shape (n, 3) [N]."""
        self.is_steady = False
        """Whether friction follows from what points moved since the last equilibrium."""
        self.lent = 0.0
        """Energy that the overlaps got in this step as leads changed [J]."""
        self._limits: list[tuple[ContactSurface, np.ndarray, np.ndarray]] = []
        self._numbers = np.zeros(N_LAW)
        stiffness, stiffer = (self.stiffness, self._implicit), STIFFER if self.stop else 1.0
        self._numbers[:STEADY] = *stiffness, self._damping, self._softness, friction, stiffer

    def forces(
        self,
        overlaps: Sequence[Overlap],
        dt: float,
        last: float,
        touched: Mapping[int, np.ndarray],
        before: float = 0.0,
        implicit: Sequence[Implicit] = (),
    ) -> list[np.ndarray]:
        """Return the forces on the points of each overlap over a step dt [s], shape (n, 3) [N].

        last: length of the step before [s]. touched: of the points of each surface, by its identity, shape (m,): those that
        friction holds are marked. before: power of the forces `given` in the step before along the velocities of now [W].
        implicit: normal forces of each overlap, where the law is implicit.

        Of the work f (d' - d) of implicit forces, where the depth goes from d to d' in a step, the overlap stores
        ½ k (d'² - d²). The rest is taken, and half of Δt f times the loss of the velocity of approach. Points ahead of the
        surface store nothing.
        """
        extras = [NONE] * len(overlaps)
        if self.stop is not None:
            springs = self._springs(overlaps)
            if all(overlap.apart for overlap in overlaps):
                return self._forces_apart(self.stop, overlaps, springs, dt, last, touched)
            extras = self.stop.force_on_all(overlaps, springs.pressures, self._tangents(overlaps, springs, dt), dt)
        found, self.given, sums = [], [], np.zeros(N_SUMS)
        self._limits.clear()
        self._numbers[STEADY] = self.is_steady
        for i, (overlap, extra) in enumerate(zip(overlaps, extras, strict=True)):
            one, n = overlap.one, len(overlap.listed)
            force, given, limits = np.empty((n, 3)), np.empty((n, 3)), np.empty((n, 2))
            normal_forces = np.array(implicit[i]) if self.is_implicit else NO_FORCES
            new, drag = NOT_NEW if overlap.new is None else overlap.new, NONE if one.drag is None else one.drag
            points = overlap.listed, overlap.depth, overlap.normal, overlap.area, overlap.relative, new
            results = force, given, limits, sums
            find_point_forces(self._numbers, overlap.share, *points, extra, normal_forces, drag, one.slip, dt, last, *results)
            if self._friction > 0.0:
                touched[id(one)][overlap.listed] = True
                if self.is_steady and one.drag is None:
                    self._limits.append((one, overlap.listed, limits))
            found.append(force)
            self.given.append(given)
        # a damper that stops a node in a step takes half of its energy by its force before, along what is left of the speed
        at_both_ends = -0.5 * last * (before + sums[NOW])
        if self.is_implicit:
            taken = self.lost - sums[ENTERED] + at_both_ends
            self.lost = float(sums[LOST])
        elif self.counts_both_ends:
            taken = at_both_ends + sums[ENTERED]
        elif self.stop is None:
            taken = sums[RUBBED] + last * sums[POWER]
        else:
            damped = [np.einsum("ij,ij->i", of, overlap.normal) for of, overlap in zip(self.given, overlaps, strict=True)]
            taken = sums[RUBBED] + self.stop.taken(damped, float(sums[POWER]), last)
        self.held = Held(float(sums[STORED]), float(taken) - self.lent, float(sums[PENDING]))
        return found

    def reach_equilibrium(self) -> None:
        """Continue sliding points from the positions at which friction holds them."""
        for one, at, limits in self._limits:
            one.slip[at] = _held(one.slip[at], *limits.T)

    def normal_stiffness(self, overlap: Overlap) -> np.ndarray:
        """Return the stiffness of the implicit normal forces of an overlap, shape (n,) [N/m]."""
        return np.asarray(self._implicit * overlap.share * overlap.area)

    def settle(self, overlaps: Sequence[Overlap], dt: float, last: float) -> None:
        """Compute the contact forces on flat-sided rigid bodies first, so that other contacts of these bodies can include
        them."""
        if self.stop is not None:
            self._find_apart(self.stop, overlaps, self._springs(overlaps), dt, last)

    def _springs(self, overlaps: Sequence[Overlap]) -> "Springs":
        springs = [overlap.share * self.stiffness * overlap.area for overlap in overlaps]
        hardened = [self._softness * overlap.depth**2 for overlap in overlaps]
        depths = [overlap.depth for overlap in overlaps]
        pressures = [k * d * (1.0 + h) for k, d, h in zip(springs, depths, hardened, strict=True)]
        energies = [0.5 * k * d**2 * (1.0 + 0.5 * h) for k, d, h in zip(springs, depths, hardened, strict=True)]
        return Springs(springs, pressures, sum(float(np.sum(energy)) for energy in energies))

    def _find_apart(
        self, stop: DeadStop, overlaps: Sequence[Overlap], springs: "Springs", dt: float, last: float
    ) -> tuple[list[np.ndarray], ...]:
        """Return, for each overlap, the displacements of points from where they stuck [m], the spring forces limited by
        friction, the forces of dampers along the normals, and friction [N]."""
        carried, drags = [], []
        for overlap, spring, pressure in zip(overlaps, springs.stiffness, springs.pressures, strict=True):
            n, before = overlap.normal, overlap.one.slip[overlap.listed]
            along = _along(overlap.relative, n)
            carried.append(_along(before, n) + last * along)
            drags.append(_limited(-spring[:, None] * carried[-1], self._friction * pressure))
        tangents = self._tangents(overlaps, springs, dt)
        return carried, drags, *stop.forces_apart(overlaps, springs.pressures, drags, self._friction, tangents, dt)

    def _forces_apart(
        self,
        stop: DeadStop,
        overlaps: Sequence[Overlap],
        springs: "Springs",
        dt: float,
        last: float,
        touched: Mapping[int, np.ndarray],
    ) -> list[np.ndarray]:
        """Return contact forces with one damper for each point, along the normal and along the surface."""
        taken = pending = 0.0
        found, given = [], []
        parts = overlaps, springs.stiffness, springs.pressures, *self._find_apart(stop, overlaps, springs, dt, last)
        for overlap, spring, pressure, carried, drag, extra, dragged in zip(*parts, strict=True):
            one, at, press = overlap.one, overlap.listed, np.maximum(pressure + extra, 0.0)
            force, damped = press[:, None] * overlap.normal, (press - pressure)[:, None] * overlap.normal
            if self._friction > 0.0:
                most, before = self._friction * press, one.slip[at]
                slides = np.linalg.norm(dragged, axis=1) >= most * (1.0 - ROUNDED)
                one.slip[at] = np.where(slides[:, None], _held(carried, spring, most), carried)
                force += dragged
                damped += np.where(slides[:, None], 0.0, dragged - drag)
                moved = last * _along(overlap.relative, overlap.normal)
                taken += taken_by_friction(spring, before, carried, dragged, moved, np.zeros(len(press)), slides)
                touched[id(one)][at] = True
            pending += 0.5 * (last or dt) * float(np.sum(force * overlap.relative))
            given.append(damped)
            found.append(force)
        taken += stop.taken_apart(overlaps, given, springs.pressures, last)
        self.held = Held(springs.stored, taken, pending)
        return found

    def separate(self, last: float, before: float = 0.0) -> None:
        """End the contact: there is no overlap. last: length of the previous step [s]; before: see `forces`."""
        self.given = []
        ended = self.lost - 0.5 * last * before - self.lent
        self.held = Held(taken=ended if self.stop is None else self.stop.end(last))
        self.lost = 0.0
        self._limits.clear()

    def _tangents(self, overlaps: Sequence[Overlap], springs: "Springs", dt: float) -> list[np.ndarray]:
        """Return the stiffness of each point against more depth, and the one at the end of a step dt [s], as it counts in the
        bound on the step, shape (2, n) [N/m]."""
        found = []
        for overlap, spring in zip(overlaps, springs.stiffness, strict=True):
            approach = np.maximum(-np.einsum("ij,ij->i", overlap.relative, overlap.normal), 0.0)
            now = spring * (1.0 + 3.0 * self._softness * overlap.depth**2)
            later = spring * (1.0 + 3.0 * self._softness * (overlap.depth + dt * approach) ** 2)
            found.append(np.stack([now, self._followed**2 * later]))
        return found


class Springs(NamedTuple):
    """Springs of the overlaps of bodies that do not deform."""

    stiffness: list[np.ndarray]  # of the points of each overlap, (n,) [N/m]
    pressures: list[np.ndarray]  # (n,) [N]
    stored: float  # [J]


def _stiff(courant: float) -> float:
    """Return ω Δt for the largest stable frequency ω of the springs of a contact, for a step of this part of the stable one.

    Waves of the body have at most 2 `courant`. Central differences, with dampers that act by the velocities of the step before,
    are stable for (ω Δt)² + 4 ζ ω Δt ≤ 4 - (2 courant)² [Belytschko, Liu & Moran 2000, section 6.6].
    """
    room = max(ROOM * (4.0 - (2.0 * courant) ** 2), LEAST_ROOM)
    return sqrt((2.0 * DAMPING) ** 2 + room) - 2.0 * DAMPING


def rests_on_flat_side(one: ContactSurface, listed: np.ndarray) -> bool:
    """Return True if all listed points of a surface lie on flat sides and edges; a round side can roll."""
    n_faces = len(one.place) - one.n_edge_points
    return bool(one.on_flat_side[listed[listed < n_faces]].all())


def stop_apart(*sides: ContactSurface) -> bool:
    """Return True if non-deforming bodies are stopped point by point: they have edges, and planes bound one of the two."""
    return all(side.n_edge_points > 0 for side in sides) and (len(sides) == 1 or any(side.faces is not None for side in sides))


def mean_way(overlaps: Sequence[Overlap], one: ContactSurface) -> np.ndarray:
    """Return the unit vector of the mean normal of overlaps, (3,); its sign has no meaning."""
    way = np.zeros(3)
    for overlap in overlaps:
        sign = 1.0 if overlap.one is one else -1.0
        way += sign * np.sum((overlap.share * overlap.area * overlap.depth)[:, None] * overlap.normal, axis=0)
    size = float(np.linalg.norm(way))
    return way / size if size > 0.0 else way


def _along(vectors: np.ndarray, normal: np.ndarray) -> np.ndarray:
    return np.asarray(vectors - np.einsum("ij,ij->i", vectors, normal)[:, None] * normal)


def _limited(drag: np.ndarray, most: np.ndarray) -> np.ndarray:
    """Return forces, shape (n, 3), none larger than `most`, shape (n,)."""
    size = np.linalg.norm(drag, axis=1)
    slides = size > most
    drag[slides] *= (most[slides] / size[slides])[:, None]
    return drag


def _held(carried: np.ndarray, spring: np.ndarray, most: np.ndarray) -> np.ndarray:
    """Return the displacements of springs limited by friction."""
    size = np.linalg.norm(carried, axis=1)
    longest = np.where(spring > 0.0, most / np.where(spring > 0.0, spring, 1.0), 0.0)
    return np.asarray(carried * np.minimum(1.0, longest / np.maximum(size, TINY))[:, None])


def coefficient(kind: str, friction: float | None) -> float:
    """The coefficient μ of a kind of contact, `frictionless`, `stick` or `coulomb`."""
    return STICKS if kind == "stick" else friction or 0.0


def swing_of(cell: float, gravity: float, speed: float) -> float:
    """Return the target oscillation rate of bodies that do not deform [1/s], for cells [m], gravity [m/s²] and speeds
    [m/s]."""
    return max(sqrt(gravity / (SINK * cell)), speed / (IMPACT * cell))
