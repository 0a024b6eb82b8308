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
from pellucid.contact.feet import Feet
from pellucid.contact.images import Described

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
TINY = 1e-300
ROUNDED = 1e-6  # of its limit, by which the drag of what slides may be off it
ROUNDED_START = 1e-9  # of a length of the mesh: depth at the start that is rounding
IMPLICIT = 25.0
"""Rate of a body on implicit normal forces over its own rate, as far as the step is small enough for that."""
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
    apart: bool = False  # whether each point stops by itself: a flat side on a plane
    new: np.ndarray | None = None  # (n,) whether each did not overlap in the step before; of sheets and
    # implicit normal forces alone


class Implicit(NamedTuple):
    """Implicit normal forces of n points over a step."""

    press: np.ndarray  # (n,) [N]
    after: np.ndarray  # (n,) depths at the end of the step [m]


class GivenBefore:
    """Forces of dampers and friction that a contact gave in the last step, on points and against their feet.

    It tells their power along the velocities at the end of that step, which the energy that they took counts.
    """

    def __init__(self) -> None:
        self._listed, self._force = np.zeros(0, np.int64), np.zeros((0, 3))
        self._before, self._pressed = self._listed, self._force
        self._feet: Feet | None = None
        self._images = np.zeros(0, np.int64), np.zeros((0, 3))

    def keep(self, listed: np.ndarray, force: np.ndarray, feet: Feet | None = None, other: Described | None = None) -> None:
        """Keep forces [N] on listed points, shape (n, 3); feet: on the points and images of another surface."""
        self._listed, self._force, self._feet = listed, force, feet
        if other is not None:
            self._images = other.point, other.flip

    def forget(self) -> np.ndarray:
        """Keep nothing but what `pressed` returns; which points had such forces."""
        listed = self._before = self._listed
        self._pressed = self._force
        self.keep(self._listed[:0], self._force[:0])
        return listed

    def pressed(self, overlap: Overlap) -> np.ndarray:
        """Return the normal forces in the last step [N], shape (n,), of the points of an overlap; 0 for points without one.

        They were kept as their opposites, as `OverlapLaw` gives implicit forces.
        """
        listed = overlap.listed
        if not len(self._before):
            return np.zeros(len(listed))
        at = np.minimum(np.searchsorted(self._before, listed), len(self._before) - 1)
        press = -np.einsum("ij,ij->i", self._pressed[at], overlap.normal)
        return np.where(self._before[at] == listed, np.maximum(press, 0.0), 0.0)

    def power(self, velocity: np.ndarray, of_other: np.ndarray) -> float:
        """Return the power [W] along velocities of the points less those at the feet [m/s].

        of_other: of the points of the other surface, shape (q, 3), or where there are no feet, of a wall, shape (3,).
        """
        if not len(self._listed):
            return 0.0
        along = of_other
        if self._feet is not None:
            point, flip = self._images
            all_points = np.concatenate([of_other, flip * of_other[point]]) if len(point) else of_other
            along = self._feet.gather(all_points)
        return float(np.sum(self._force * (velocity[self._listed] - along)))

    def state_numbers(self) -> list[object]:
        """Return the state for a checkpoint."""
        feet = None if self._feet is None else [part.tolist() for part in self._feet]
        return [self._listed.tolist(), self._force.tolist(), feet, [part.tolist() for part in self._images]]

    def restore(self, numbers: Sequence[Any]) -> None:
        """Go on from a checkpoint."""
        listed, force, feet, (point, flip) = numbers
        self._listed, self._force = np.array(listed, np.int64), np.reshape(np.array(force, float), (-1, 3))
        self._feet = None
        if feet is not None:
            self._feet = Feet(np.array(feet[0], np.int64), np.array(feet[1], np.int64), np.array(feet[2], float))
        self._images = np.array(point, np.int64), np.reshape(np.array(flip, float), (-1, 3))


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
        """Let everything press from the start on: the surfaces touched each other in an earlier run."""
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
        """Go on from a checkpoint."""
        self._begun, self.depth, recent = numbers
        self._recent = list(recent)


class OverlapLaw:
    """What the points in an overlap feel.

    sides: the surfaces that touch; one alone where the other body neither deforms nor gives way, as a wall. friction:
    coefficient μ, `STICKS` where they stick while they press. courant: of the case's `time`. swing: how fast bodies that do not
    deform are to swing on each other [1/s], see `swing_of`; 0 where nothing moves them, and their materials tell. cell: edge
    of the cells [m]. step: fixed step of the case [s], 0 where `courant` sets it.
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
        self._mass = 1.0 / max(sum(1.0 / side.rigid_mass for side in sides), 1e-300)
        soft = [side for side in sides if self._hard or not side.is_hard]
        with_sheet = any(side.is_sheet for side in soft)
        damping = SHEET_DAMPING if with_sheet else DAMPING
        rates = [side.rate for side in soft]
        self._implicit = IMPLICIT**2 / sum(1.0 / (side.mass_per_area * side.rate**2) for side in soft)
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
        self._limits: list[tuple[ContactSurface, np.ndarray, np.ndarray, np.ndarray]] = []

    def forces(
        self,
        overlaps: Sequence[Overlap],
        dt: float,
        last: float,
        touched: Mapping[int, np.ndarray],
        before: float = 0.0,
        implicit: Sequence[Implicit] = (),
    ) -> list[np.ndarray]:
        """Forces on the points of each overlap over a step dt [s], shape (n, 3) [N]; last: length of the step before [s].

        touched: of the points of each surface, by its identity, shape (m,): those that friction holds are marked. before: power
        of the forces `given` in the step before along the velocities of now [W]. implicit: normal forces of each overlap,
        where the law is implicit.
        """
        if self.is_implicit:
            return self._forces_with(implicit, overlaps, dt, last, touched, before)
        springs = [overlap.share * self.stiffness * overlap.area for overlap in overlaps]
        hardened = [self._softness * overlap.depth**2 for overlap in overlaps]
        pressures = [k * overlap.depth * (1.0 + h) for k, overlap, h in zip(springs, overlaps, hardened, strict=True)]
        tangents = self._tangents(overlaps, springs, dt) if self.stop else []
        if self.stop is not None and all(overlap.apart for overlap in overlaps):
            return self._forces_apart(self.stop, overlaps, pressures, springs, hardened, tangents, dt, last, touched)
        extras = self.stop.force_on_all(overlaps, pressures, tangents, dt) if self.stop else [0.0] * len(overlaps)
        stored = taken = pending = power = 0.0
        found, given, self.given = [], [], []
        self._limits.clear()
        for overlap, pressure, spring, h, extra in zip(overlaps, pressures, springs, hardened, extras, strict=True):
            n = overlap.normal
            approach = -np.einsum("ij,ij->i", overlap.relative, n)
            damping = overlap.share * self._damping * overlap.area
            press = np.maximum(pressure + damping * approach + extra, 0.0)
            force = press[:, None] * n
            stored += 0.5 * float(np.sum(spring * overlap.depth**2 * (1.0 + 0.5 * h)))
            power += float(np.sum((press - pressure) * approach))
            given.append(press - pressure)
            if self._friction > 0.0:
                along = overlap.relative + approach[:, None] * n
                # what presses harder than the overlap alone is held by as much stiffer springs along it
                holds = spring * np.clip(press / np.maximum(pressure, TINY), 1.0, STIFFER) if self.stop else spring
                drag, lost = self._drag(overlap, along, self._friction * press, holds, damping, last)
                force += drag
                taken += lost
                touched[id(overlap.one)][overlap.listed] = True
            # before the first step nothing was done, and the first does half of its own
            pending += 0.5 * (last or dt) * float(np.sum(force * overlap.relative))
            found.append(force)
            self.given.append(force - pressure[:, None] * n)
        if self.counts_both_ends:
            # a damper that stops a node in a step takes half of its energy by its force before, along what is left of the speed
            now = sum(float(np.sum(part * o.relative)) for part, o in zip(self.given, overlaps, strict=True))
            taken = -0.5 * last * (before + now)
            for overlap, spring in zip(overlaps, springs, strict=True):
                taken += _lost_on_entry(overlap, spring, last)
        else:
            taken += last * power if self.stop is None else self.stop.taken(given, power, last)
        self.held = Held(stored, taken - self.lent, pending)
        return found

    def reach_equilibrium(self) -> None:
        """Let points that slide go on from where friction holds them."""
        for one, at, spring, most in self._limits:
            one.slip[at] = _held(one.slip[at], spring, most)

    def normal_stiffness(self, overlap: Overlap) -> np.ndarray:
        """Return the stiffness of the implicit normal forces of an overlap, shape (n,) [N/m]."""
        return np.asarray(self._implicit * overlap.share * overlap.area)

    def _forces_with(
        self,
        implicit: Sequence[Implicit],
        overlaps: Sequence[Overlap],
        dt: float,
        last: float,
        touched: Mapping[int, np.ndarray],
        before: float,
    ) -> list[np.ndarray]:
        """Return the forces of overlaps whose normal forces are known, with friction.

        Of f (d' - d), where the depth goes from d to d' in a step, the overlap stores ½ k (d'² - d²) and the rest is taken, and
        half of Δt f times the loss of the velocity of approach besides. What lies ahead of the surface stores nothing.
        """
        stored = pending = now = lost = entered = 0.0
        found, self.given = [], []
        for overlap, (press, after) in zip(overlaps, implicit, strict=True):
            n, k = overlap.normal, self.normal_stiffness(overlap)
            energy = 0.5 * k * np.maximum(overlap.depth, 0.0) ** 2
            opening = np.einsum("ij,ij->i", overlap.relative, n)
            normal, drag = press[:, None] * n, np.zeros((len(press), 3))
            stored += float(np.sum(energy))
            if overlap.new is not None:  # the energy of the way that points came in within the step before nothing gave
                came_in = overlap.new & (-2.0 * (last or dt) * opening > overlap.depth)
                entered += float(np.sum(energy[came_in]))
            later = 0.5 * k * np.maximum(after, 0.0) ** 2
            lost += float(np.sum(press * (after - overlap.depth - 0.5 * dt * opening) - later + energy))
            if self._friction > 0.0:
                along, area = overlap.relative - opening[:, None] * n, overlap.share * overlap.area
                most, holds = self._friction * press, self.stiffness * area
                drag, _ = self._drag(overlap, along, most, holds, self._damping * area, last)
                touched[id(overlap.one)][overlap.listed] = True
                now += float(np.sum(drag * along))
                pending += 0.5 * (last or dt) * float(np.sum(drag * along))
            found.append(normal + drag)
            self.given.append(drag - normal)
        taken = self.lost - entered - 0.5 * last * (before + now)
        self.lost = lost
        self.held = Held(stored, taken, pending)
        return found

    def settle(self, overlaps: Sequence[Overlap], dt: float, last: float) -> None:
        """Compute the forces of flat sides on rigid bodies, so that their other contacts can account for them."""
        if self.stop is None:
            return
        springs = [overlap.share * self.stiffness * overlap.area for overlap in overlaps]
        pressures = [k * o.depth * (1.0 + self._softness * o.depth**2) for k, o in zip(springs, overlaps, strict=True)]
        _, drags = self._carried(overlaps, springs, pressures, last)
        self.stop.forces_apart(overlaps, pressures, drags, self._friction, self._tangents(overlaps, springs, dt), dt)

    def _carried(
        self, overlaps: Sequence[Overlap], springs: Sequence[np.ndarray], pressures: Sequence[np.ndarray], last: float
    ) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Return the displacement of points from where they stuck [m], and the spring forces limited by friction [N]."""
        carried, drags = [], []
        for overlap, spring, pressure in zip(overlaps, springs, pressures, strict=True):
            n, before = overlap.normal, overlap.one.slip[overlap.listed]
            along = overlap.relative - np.einsum("ij,ij->i", overlap.relative, n)[:, None] * n
            carried.append(before - np.einsum("ij,ij->i", before, n)[:, None] * n + last * along)
            drags.append(_limited(-spring[:, None] * carried[-1], self._friction * pressure)[0])
        return carried, drags

    def _forces_apart(
        self,
        stop: DeadStop,
        overlaps: Sequence[Overlap],
        pressures: Sequence[np.ndarray],
        springs: Sequence[np.ndarray],
        hardened: Sequence[np.ndarray],
        tangents: Sequence[np.ndarray],
        dt: float,
        last: float,
        touched: Mapping[int, np.ndarray],
    ) -> list[np.ndarray]:
        """Return contact forces with one damper for each point, along the normal and along the surface."""
        befores = [overlap.one.slip[overlap.listed] for overlap in overlaps]
        carried, drags = self._carried(overlaps, springs, pressures, last)
        extras, dragged = stop.forces_apart(overlaps, pressures, drags, self._friction, tangents, dt)
        stored = taken = pending = 0.0
        found, given = [], []
        for i, overlap in enumerate(overlaps):
            n, spring, press = overlap.normal, springs[i], np.maximum(pressures[i] + extras[i], 0.0)
            approach = -np.einsum("ij,ij->i", overlap.relative, n)
            along = overlap.relative + approach[:, None] * n
            force, damped = press[:, None] * n, (press - pressures[i])[:, None] * n
            stored += 0.5 * float(np.sum(spring * overlap.depth**2 * (1.0 + 0.5 * hardened[i])))
            if self._friction > 0.0:
                most = self._friction * press
                slides = np.linalg.norm(dragged[i], axis=1) >= most * (1.0 - ROUNDED)
                overlap.one.slip[overlap.listed] = np.where(slides[:, None], _held(carried[i], spring, most), carried[i])
                force += dragged[i]
                damped += np.where(slides[:, None], 0.0, dragged[i] - drags[i])
                still = np.zeros(len(press))
                taken += taken_by_friction(spring, befores[i], carried[i], dragged[i], last * along, still, slides)
                touched[id(overlap.one)][overlap.listed] = True
            pending += 0.5 * (last or dt) * float(np.sum(force * overlap.relative))
            given.append(damped)
            found.append(force)
        taken += stop.taken_apart(overlaps, given, pressures, last)
        self.held = Held(stored, taken, pending)
        return found

    def separate(self, last: float, before: float = 0.0) -> None:
        """Nothing overlaps any more; last: length of the step before [s]; before: see `forces`."""
        self.given = []
        ended = self.lost - 0.5 * last * before - self.lent
        self.held = Held(taken=ended if self.stop is None else self.stop.end(last))
        self.lost = 0.0
        self._limits.clear()

    def _tangents(self, overlaps: Sequence[Overlap], springs: Sequence[np.ndarray], dt: float) -> list[np.ndarray]:
        """Return the stiffness of each point against more depth, and the one at the end of a step dt [s], as it counts in the
        bound on the step, shape (2, n) [N/m]."""
        found = []
        for overlap, spring in zip(overlaps, springs, strict=True):
            approach = np.maximum(-np.einsum("ij,ij->i", overlap.relative, overlap.normal), 0.0)
            now = spring * (1.0 + 3.0 * self._softness * overlap.depth**2)
            later = spring * (1.0 + 3.0 * self._softness * (overlap.depth + dt * approach) ** 2)
            found.append(np.stack([now, self._followed**2 * later]))
        return found

    def _drag(
        self, overlap: Overlap, along: np.ndarray, most: np.ndarray, spring: np.ndarray, damping: np.ndarray, last: float
    ) -> tuple[np.ndarray, float]:
        """Friction of points with velocities along the other body [m/s], shape (n, 3), at most so much [N] and on springs of
        such stiffness [N/m], shape (n,); the energy that it took since the last step [J]."""
        one, n, at = overlap.one, overlap.normal, overlap.listed
        if one.drag is not None:
            drag, _ = _limited(-one.drag[at][:, None] * along, most)
            return drag, -last * float(np.sum(drag * along))
        before = one.slip[at]
        carried = before - np.einsum("ij,ij->i", before, n)[:, None] * n + last * along
        drag, slides = _limited(-spring[:, None] * carried - damping[:, None] * along, most)
        kept = _held(carried, spring, most)
        if self.is_steady:
            self._limits.append((one, at, spring, most))
            one.slip[at] = carried
            before, carried = _held(before, spring, most), kept
        else:
            one.slip[at] = np.where(slides[:, None], kept, carried)
        damped = last * damping * np.sum(along * along, axis=1)
        return drag, taken_by_friction(spring, before, carried, drag, last * along, damped, slides)


def _stiff(courant: float) -> float:
    """Return ω Δt for the largest stable frequency ω of the springs of a contact, for a step of this part of the stable one.

    Waves of the body have at most 2 `courant`. Central differences, with dampers that act by the velocities of the step before,
    are stable for (ω Δt)² + 4 ζ ω Δt ≤ 4 - (2 courant)² [Belytschko, Liu & Moran 2000, section 6.6].
    """
    room = max(ROOM * (4.0 - (2.0 * courant) ** 2), LEAST_ROOM)
    return sqrt((2.0 * DAMPING) ** 2 + room) - 2.0 * DAMPING


def _lost_on_entry(overlap: Overlap, spring: np.ndarray, last: float) -> float:
    """Return the energy that points of a sheet lose as they come into an overlap within the last step [J].

    A point that comes in by a depth d of its way s in a step gives ½ k d s to the springs, as leapfrog steps count, which hold
    ½ k d² then. With critical dampers it does not come out again.
    """
    if overlap.new is None:
        return 0.0
    way = -last * np.einsum("ij,ij->i", overlap.relative, overlap.normal)
    return 0.5 * float(np.sum(np.where(overlap.new, spring * overlap.depth * np.maximum(way - overlap.depth, 0.0), 0.0)))


def may_press(depth: np.ndarray, relative: np.ndarray, normal: np.ndarray, step: float) -> np.ndarray:
    """Return which points overlap, or come in within a step [s] and half of it more; shape (n,)."""
    return np.asarray(depth - 1.5 * step * np.minimum(np.einsum("ij,ij->i", relative, normal), 0.0) > 0.0)


def rests_on_flat_side(one: ContactSurface, listed: np.ndarray) -> bool:
    """Whether points of a surface, by their indices, lie on flat sides and edges alone: a round side can roll."""
    n_faces = len(one.place) - one.n_edge_points
    return bool(one.on_flat_side[listed[listed < n_faces]].all())


def stop_apart(*sides: ContactSurface) -> bool:
    """Whether bodies that do not deform are stopped point by point: they have edges, and planes bound one of two."""
    return all(side.n_edge_points > 0 for side in sides) and (len(sides) == 1 or any(side.faces is not None for side in sides))


def mean_way(overlaps: Sequence[Overlap], one: ContactSurface) -> np.ndarray:
    """Return the unit vector of the mean normal of overlaps, (3,); its sign has no meaning."""
    way = np.zeros(3)
    for overlap in overlaps:
        sign = 1.0 if overlap.one is one else -1.0
        way += sign * np.sum((overlap.share * overlap.area * overlap.depth)[:, None] * overlap.normal, axis=0)
    size = float(np.linalg.norm(way))
    return way / size if size > 0.0 else way


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
