"""Forces of an overlap: pressure, damping and friction on surface points that lie inside another body.

`pellucid.contact.surface_pairs` describes the method and the reasons for it.
"""

from collections.abc import Mapping, Sequence
from math import sqrt
from typing import Any, NamedTuple

import numpy as np

from pellucid.contact.contact_energy import Held
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
    begin_friction,
    end_friction,
    find_point_forces,
    limit_slip,
)

ROOM, LEAST_ROOM = 0.9, 0.3
"""`ROOM`: fraction of what the waves of the body leave of the stability range of central differences, (ω Δt)² ≤ 4, that
contact springs and dampers may use, see `_stiff`; `LEAST_ROOM`: smallest part of that range that they may use."""
SHEET_STIFF, SHEET_DAMPING = 0.5, 1.0
"""Product ω Δt of oscillation rate and time step, and damping ratio, for contact of a deforming membrane, whose nodes do
not rebound. With a critical damper that uses the velocities of the previous step, a step is stable up to ω Δt = 0.83."""
SINK, IMPACT = 3e-4, 0.2
"""Penetration of a rigid body into another body that does not deform [cells]: at rest on its whole side, and in an impact
at the initial speed."""
RESOLVED = 0.3
"""Largest product of step size and oscillation rate of a rigid body on its contacts, for any `time.courant`. With a longer
step the body penetrates too deep before a force acts, and is thrown back."""
HARDENS = 0.05
"""Depth scale [cells] of the hardening of contact between two bodies that do not deform: its stiffness grows with the
square of depth / `HARDENS`. Bodies reach this depth only under more than their own weight: under bodies that lie on
them, or under loads."""
STIFFER = 4.0
"""Largest ratio of friction stiffness to overlap stiffness between bodies that do not deform; friction then oscillates
twice as fast as the overlap."""
OUT = 10
"""Number of steps in which all depths must be smaller than the initial overlap before it is reduced."""
ROUNDED_START = 1e-9  # initial depth that counts as rounding, relative to a length of the mesh
IMPLICIT, IMPLICIT_SHEETS = 25.0, 100.0
"""Ratio of the oscillation rate of contact by implicit normal forces to the largest oscillation rate of the body, if the
step is small enough; `IMPLICIT_SHEETS` for membranes, which are thin compared with the nodal displacement in a step."""
STICKS = 1e12  # coefficient of friction for contact without sliding
NO_VALUES, NOT_NEW, NO_FORCES = np.zeros(0), np.zeros(0, bool), np.zeros((3, 0))


class Overlap(NamedTuple):
    """Points of a surface that lie inside another body or behind a wall, with the data from which `OverlapLaw` computes the
    forces on them; n is the number of points."""

    one: ContactSurface
    listed: np.ndarray  # (n,) indices of the overlapping points
    depth: np.ndarray  # (n,) depths of the points inside the other body [m]
    normal: np.ndarray  # (n, 3) outward unit normals of the other body
    area: np.ndarray  # (n,) effective areas [m²]
    relative: np.ndarray  # (n, 3) velocities relative to the other body [m/s]
    share: float = 1.0  # fraction of the contact stiffness that these points have
    apart: bool = False  # True for one damper per point: a flat side on a plane
    new: np.ndarray | None = None  # (n,) mask of the points without overlap in the previous step; None if no body deforms


class Implicit(NamedTuple):
    """Implicit normal forces of the n points of an overlap over a step, the result of `pellucid.contact.implicit` for
    `OverlapLaw`."""

    press: np.ndarray  # (n,) normal forces [N]
    after: np.ndarray  # (n,) depths at the end of the step [m]
    before: np.ndarray  # (n,) normal forces of the previous step [N]


class StartOverlap:
    """Initial overlap of two surfaces, which exerts no pressure.

    The initial overlap is the largest depth at the start. It is subtracted from the depths of all points: the surfaces
    begin in contact without pressure, like surfaces of bodies that are thinner by this depth. When the surfaces separate,
    the initial overlap decreases to the largest depth of the last `OUT` steps. (A point near a curved surface may be missed
    in one step. Without this delay the full depth would push the point off in the next step.) The initial overlap decreases
    only when there is no pressure, so that the energy of the remaining depths is a function of the positions alone.

    Contact of a body with itself is different: each contact of a point with a triangle has its own initial overlap, stored
    in its slot (`pellucid.contact.triangles.slots.Slots`). The overlaps of such a body lie at unrelated places, and one
    depth for all would delay contact at all other places by this depth. The rule for slots does not suit two bodies: a
    point that slides along the other body would keep the initial depth of the place where the sliding started, so that the
    force on the point would depend on its path.

    Parameters
    ----------
    length
        Length of the order of the point spacing [m]; depths below `ROUNDED_START` times this length count as zero.
    """

    def __init__(self, length: float) -> None:
        self._rounding, self.depth, self._begun = ROUNDED_START * length, 0.0, False
        self._recent: list[float] = []  # largest depths of the last steps
        self._by_equilibria = False

    def skip(self) -> None:
        """Use no initial overlap: all overlaps exert pressure, because the surfaces were already in contact in an earlier
        run."""
        self._begun = True

    def reduce(self, depth: np.ndarray) -> np.ndarray:
        """Update the initial overlap and return the depths of all points near the other surface minus this overlap [m], shape
        (n,).

        depth: depths of these points [m], shape (n,).
        """
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
        """From now on, update the initial overlap only in equilibria."""
        self._by_equilibria = True

    def reach_equilibrium(self) -> None:
        """Reduce the initial overlap to the largest depth in this equilibrium."""
        if self._by_equilibria and self._begun and self.depth > 0.0:
            self.depth = min(self.depth, self._recent[-1])
            if self.depth <= self._rounding:
                self.depth = 0.0

    def state_numbers(self) -> list[object]:
        """Return the initial overlap and the largest depths of the last steps, for a checkpoint."""
        return [self._begun, self.depth, self._recent]

    def restore(self, numbers: Sequence[Any]) -> None:
        """Restore the initial overlap, the result of `state_numbers`, from a checkpoint."""
        self._begun, self.depth, recent = numbers
        self._recent = list(recent)


class OverlapLaw:
    """Force law for the points of an overlap.

    sides: surfaces in contact; only one if the other body neither deforms nor moves under contact forces, e.g. a wall.
    friction: coefficient μ, or `STICKS` for no sliding. courant: see `time` of the case. swing: target oscillation rate of
    bodies that do not deform [1/s], see `swing_of`; 0 if nothing moves the bodies and their materials define the rate.
    cell: cell size [m]. step: fixed step of the case [s]; 0 if `courant` defines the step.
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
        self.friction = friction
        """Coefficient of friction, or `STICKS`."""
        self._hard = all(side.is_hard for side in sides)
        self._mass = 1.0 / max(sum(1.0 / side.rigid_mass for side in sides), TINY)
        soft = [side for side in sides if self._hard or not side.is_hard]
        with_sheet = any(side.is_sheet for side in soft)
        damping = SHEET_DAMPING if with_sheet else max(side.damping for side in soft)
        harder = IMPLICIT_SHEETS if with_sheet else IMPLICIT
        of_layers = [side.mass_per_area * side.rate**2 for side in soft]
        self._implicit = harder**2 / sum(1.0 / layer for layer in of_layers)
        for i, side in enumerate(soft):
            if side.follows_steps:
                part = step * side.rate if step > 0.0 else courant
                stiff = of_layers[i] * ((SHEET_STIFF if with_sheet else _stiff(part, damping)) / part) ** 2
                of_layers[i] = min(max(stiff, side.stiffness_range[0]), side.stiffness_range[1])
        self.compliance = {id(side): 1.0 / layer for side, layer in zip(soft, of_layers, strict=True)}
        """Compliance of each side that deforms; of all sides if none deforms [m/Pa], by the `id` of the surface."""
        self.stiffness = 1.0 / sum(self.compliance.values())
        """Contact stiffness κ [Pa/m]."""
        self.is_implicit = not self._hard and all(side.response is not None for side in soft)
        """True if normal forces are implicit in the step, see `pellucid.contact.implicit`."""
        self.lost = 0.0
        """Energy dissipated by the implicit forces of the last step, without the contribution of their power at its end [J]."""
        rigid = [side for side in sides if side.rigid_mass < np.inf]
        by_edges = self._hard and stop_apart(*sides)
        areas = {id(side): side.bearing_area() if by_edges else side.side() for side in rigid}
        if self._hard and rigid and swing > 0.0:
            self.stiffness = swing**2 * self._mass / max(areas.values())
        lightness = sum(1.0 / side.mass_per_area for side in soft)
        if with_sheet:  # a free rigid body may be lighter than the part of the sheet in contact with it
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
        """Stored, dissipated and pending energy of the overlaps in the last call of `forces` or `separate`."""
        self.counts_both_ends = self.stop is None and all(side.drag is None for side in sides)
        """True if the energy of dampers and friction is computed from their forces at both ends of a step."""
        self.given: list[np.ndarray] = []
        """Damper and friction forces on the points of each overlap [N], shape (n, 3) each; if the law is implicit, friction
        minus normal force."""
        self.is_steady = False
        """True if friction is computed from displacements since the last equilibrium."""
        self.lent = 0.0
        """Energy that the overlaps gained in this step through changes of the contact leads, i.e. of the distances ahead
        of surfaces at which contact acts [J]."""
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
        """Return the contact forces over a step of length dt [s] on the points of each overlap, in newtons, shape (n, 3)
        each.

        last: length of the previous step [s]. touched: masks of the points of each surface, shape (m,), by the `id` of the
        surface; points held by friction are marked. before: power of the forces `given` of the previous step at the current
        velocities [W]. implicit: normal forces of each overlap if the law is implicit.

        If the depth changes from d to d' in a step, an implicit force f takes the energy f (d' - d) from the bodies, and its
        spring stores ½ f²/k. The difference is dissipated. So is ½ Δt f times the decrease of the approach velocity:
        the force acts along the mean velocity, and the depth changes with the velocity at the end of the step. At
        the start of a step a spring holds ½ k d². The exception is a depth much larger than the last step left it: nothing
        has loaded the spring in this case (`pellucid.contact.point_forces.GROWN`).
        """
        extras = [NO_VALUES] * len(overlaps)
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
            new, drag = NOT_NEW if overlap.new is None else overlap.new, NO_VALUES if one.drag is None else one.drag
            points = overlap.listed, overlap.depth, overlap.normal, overlap.area, overlap.relative, new
            results = force, given, limits, sums
            find_point_forces(self._numbers, overlap.share, *points, extra, normal_forces, drag, one.slip, dt, last, *results)
            if self.friction > 0.0:
                touched[id(one)][overlap.listed] = True
                if self.is_steady and one.drag is None:
                    self._limits.append((one, overlap.listed, limits))
            found.append(force)
            self.given.append(given)
        # a damper can stop a node within a step: its energy is computed with the mean of its forces at both ends of the step
        at_both_ends = -0.5 * last * (before + sums[NOW])
        if self.is_implicit:
            taken = self.lost + at_both_ends
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
        """In an equilibrium, reduce the displacement of each sliding point from its sticking position, so that its friction
        spring force equals the friction limit."""
        for one, at, limits in self._limits:
            limit_slip(at, one.slip, limits)

    def normal_stiffness(self, overlap: Overlap) -> np.ndarray:
        """Return the stiffness of the implicit normal force at each point of an overlap, shape (n,) [N/m]."""
        return np.asarray(self._implicit * overlap.share * overlap.area)

    def settle(self, overlaps: Sequence[Overlap], dt: float, last: float) -> None:
        """Compute the forces of one damper per point on flat sides of rigid bodies in advance, so that other contacts of the
        same bodies can include them.

        overlaps: overlaps of this contact. dt, last: lengths of this and of the previous step [s].
        """
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
        """Return four lists with one array per overlap, for contact with one damper per point (solver `stop`).

        The lists contain the displacements of the points from their sticking positions [m], shape (n, 3), the friction spring
        forces within the friction limit [N], shape (n, 3), the normal damper forces [N], shape (n,), and the friction forces of
        springs and dampers together [N], shape (n, 3). springs: normal springs of the overlaps. dt, last: lengths of this and
        of the previous step [s].
        """
        carried, drags = ([np.empty_like(overlap.normal) for overlap in overlaps] for _ in range(2))
        for of, spring, pressure, *found in zip(overlaps, springs.stiffness, springs.pressures, carried, drags, strict=True):
            points = of.listed, of.normal, of.relative, of.one.slip
            begin_friction(*points, spring, self.friction * pressure, last, *found)
        tangents = self._tangents(overlaps, springs, dt)
        return carried, drags, *stop.forces_apart(overlaps, springs.pressures, drags, self.friction, tangents, dt)

    def _forces_apart(
        self,
        stop: DeadStop,
        overlaps: Sequence[Overlap],
        springs: "Springs",
        dt: float,
        last: float,
        touched: Mapping[int, np.ndarray],
    ) -> list[np.ndarray]:
        """Return the contact forces over a step on the points of each overlap [N], shape (n, 3), with one damper per point
        along the normal and along the surface; set `held` and `given` of this law.

        stop, overlaps, springs, dt, last: see `_find_apart`. touched: see `forces`.
        """
        taken = pending = 0.0
        found, given = [], []
        parts = overlaps, springs.stiffness, springs.pressures, *self._find_apart(stop, overlaps, springs, dt, last)
        for overlap, spring, pressure, carried, drag, extra, dragged in zip(*parts, strict=True):
            one, at, press = overlap.one, overlap.listed, np.maximum(pressure + extra, 0.0)
            force, damped = press[:, None] * overlap.normal, (press - pressure)[:, None] * overlap.normal
            if self.friction > 0.0:
                points = at, overlap.normal, overlap.relative, one.slip
                taken += end_friction(*points, spring, self.friction * press, last, carried, drag, dragged, damped)
                force += dragged
                touched[id(one)][at] = True
            pending += 0.5 * (last or dt) * float(np.sum(force * overlap.relative))
            given.append(damped)
            found.append(force)
        taken += stop.taken_apart(overlaps, given, springs.pressures, last)
        self.held = Held(springs.stored, taken, pending)
        return found

    def separate(self, last: float, before: float = 0.0) -> None:
        """Set `held`, the stored, dissipated and pending energy of this contact, for a step without overlap.

        last: length of the previous step [s]. before: see `forces`.
        """
        self.given = []
        ended = self.lost - 0.5 * last * before - self.lent
        self.held = Held(taken=ended if self.stop is None else self.stop.end(last))
        self.lost = 0.0
        self._limits.clear()

    def _tangents(self, overlaps: Sequence[Overlap], springs: "Springs", dt: float) -> list[np.ndarray]:
        """Return, for each overlap, the tangent stiffness of the contact springs now and at the end of a step dt [s], in
        two rows, shape (2, n) [N/m].

        The second row contains a factor with which the stiffness yields the oscillation rate that limits the step size.
        """
        found = []
        for overlap, spring in zip(overlaps, springs.stiffness, strict=True):
            approach = np.maximum(-np.einsum("ij,ij->i", overlap.relative, overlap.normal), 0.0)
            now = spring * (1.0 + 3.0 * self._softness * overlap.depth**2)
            later = spring * (1.0 + 3.0 * self._softness * (overlap.depth + dt * approach) ** 2)
            found.append(np.stack([now, self._followed**2 * later]))
        return found


class Springs(NamedTuple):
    """Normal contact springs at the points of the overlaps between two bodies that do not deform, for `OverlapLaw`."""

    stiffness: list[np.ndarray]  # stiffness of the points of each overlap, (n,) [N/m]
    pressures: list[np.ndarray]  # spring forces of the points of each overlap, (n,) [N]
    stored: float  # stored energy [J]


def _stiff(courant: float, damping: float) -> float:
    """Return ω Δt for the largest frequency ω of contact springs with the ratio `damping` that is stable with a step Δt of
    `courant` times the largest stable step of the body.

    The waves of the body use at most 2 `courant`. Central differences, with dampers that use the velocities of the previous
    step, are stable for (ω Δt)² + 4 ζ ω Δt ≤ 4 - (2 courant)² [Belytschko, Liu & Moran 2000, section 6.6].
    """
    room = max(ROOM * (4.0 - (2.0 * courant) ** 2), LEAST_ROOM)
    return sqrt((2.0 * damping) ** 2 + room) - 2.0 * damping


def rests_on_flat_side(one: ContactSurface, listed: np.ndarray) -> bool:
    """Return True if all listed points of surface `one` lie on flat sides or edges of the body, so that the body cannot
    roll on these points."""
    n_faces = len(one.place) - one.n_edge_points
    return bool(one.on_flat_side[listed[listed < n_faces]].all())


def stop_apart(*sides: ContactSurface) -> bool:
    """Return True if contact between the surfaces `sides` of bodies that do not deform has one damper per point (see
    `DeadStop`).

    This requires that every body has edge points and that planes bound at least one of two bodies.
    """
    return all(side.n_edge_points > 0 for side in sides) and (len(sides) == 1 or any(side.faces is not None for side in sides))


def mean_way(overlaps: Sequence[Overlap], one: ContactSurface) -> np.ndarray:
    """Return the unit vector of the mean normal of overlaps that include the surface `one`, weighted by depth and area,
    shape (3,); the sign of the vector has no meaning. Zero if the mean vanishes."""
    way = np.zeros(3)
    for overlap in overlaps:
        sign = 1.0 if overlap.one is one else -1.0
        way += sign * np.sum((overlap.share * overlap.area * overlap.depth)[:, None] * overlap.normal, axis=0)
    size = float(np.linalg.norm(way))
    return way / size if size > 0.0 else way


def coefficient(kind: str, friction: float | None) -> float:
    """Return the friction coefficient μ for a kind of contact: 0 for `frictionless`, `STICKS` (no sliding) for `stick`, and
    the given coefficient `friction` for `coulomb`."""
    return STICKS if kind == "stick" else friction or 0.0


def swing_of(cell: float, gravity: float, speed: float) -> float:
    """Return the target oscillation rate of bodies that do not deform on their contact springs [1/s].

    cell: cell size [m]. gravity: acceleration of gravity [m/s²]. speed: impact speed [m/s].
    """
    return max(sqrt(gravity / (SINK * cell)), speed / (IMPACT * cell))
