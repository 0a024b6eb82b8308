"""Dampers that stop two bodies that do not deform.

**One damper on the mean approach velocity of all points in contact.** The damper is so strong, relative to the mass of both
bodies in contact, that they hardly rebound. A critical damper that can only push releases the body at exp(-2) of the impact
speed; a damper of DEAD times the critical one releases it at 1/(2 DEAD)² in short steps. With finite steps a body enters by
up to the displacement of one step before any force acts, and the spring returns some hundredths of the speed. A step treats
the approach velocity implicitly: it falls to 1/(1 + c A Δt) of its value, with the damper c and the mobility A (change of
the approach velocity per unit impulse). The step size is therefore not limited by the damper. If several contacts push a
body along the same direction, each contact uses its share of the mass.

A body that rolls or slides does not approach as a whole, although each of its points may: points in front move down, points
behind move up. With few points in contact their mean alternates. Where both surfaces face each other, the velocities due to
the rotation of a body are therefore measured along its own normals: they show whether the rotation moves its surface closer
(for a round body not at all). All other velocities are measured along the normals of the other body, over which it may
slide.

**One damper for each point of a flat side on a plane.** A block that begins to tip is supported by one edge immediately.
With one damper on the mean approach, the middle of its side would support it first. The points of bodies bounded by planes
are therefore stopped individually: along the normal, where forces can only push, and along the surface, where friction
limits the forces. All forces of a step follow together from f = s + c (v - Δt A (f - s)) with the springs s, the dampers c
and the mobility A of the rigid bodies, of rank 6 or 12.
"""

from collections.abc import Sequence
from functools import partial
from math import sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.contact.contact_surface import ContactSurface

if TYPE_CHECKING:
    from pellucid.contact.overlap import Overlap

Arrays = Sequence[np.ndarray]
"""One array of point values for each overlap."""

DEAD = 8.0  # damping relative to critical damping
DEAD_APART = 64.0  # damping relative to critical damping, for one damper per point
BEARS = 0.2
"""Fraction of the difference by which, in each step, the force supported at a point approaches the spring force for its
depth.

The rest of the spring force counts as a force that stops the approach. Otherwise springs would throw back a body that
entered by the displacement of one step.
"""
MOST_ROUNDS, SETTLED = 20, 1e-3
"""`MOST_ROUNDS`: largest number of iterations that exclude tensile forces and limit friction. `SETTLED`: relative change
of the forces below which the iteration ends."""
FACING, ASKEW = 0.97, 0.9
"""Cosines of the angle between a normal and the opposite of the other surface's normal: full weight above `FACING`, zero
weight below `ASKEW`."""


class Before(NamedTuple):
    """Dampers of the last step that each act on one point of a surface. `DeadStop` stores them to compute the energy that
    they dissipate, which also depends on the velocities after that step."""

    listed: np.ndarray  # (n,) indices of the points
    force: np.ndarray  # (n, 3) damper forces [N]
    speed: np.ndarray  # (n, 3) velocities that the dampers oppose [m/s]
    borne: np.ndarray  # (n,) normal force that each point supports: running mean of its spring force [N], see `BEARS`


NOTHING = Before(np.zeros(0, np.int64), np.zeros((0, 3)), np.zeros((0, 3)), np.zeros(0))


class DeadStop:
    """Dampers that stop the approach of two bodies that do not deform, in addition to the contact springs. There is either
    one common damper on the mean approach velocity of all points, or one damper for each point of a flat side on a plane.

    sides: surfaces of the bodies; at least one belongs to a rigid body with free motion.

    Attributes
    ----------
    damped, approach : float
        Total force [N] of the common damper and mean approach velocity [m/s] at the start of the last step.
    before : dict
        Dampers of single points in the last step (`Before`), for each surface by its index in `sides`.
    """

    def __init__(self, sides: Sequence[ContactSurface]) -> None:
        self._numbers = {id(side): number for number, side in enumerate(sides)}
        self._rigid = [side for side in sides if side.rigid_mass < np.inf]
        self._now = 0.0  # mean approach velocity [m/s]
        self._speeds: list[np.ndarray] = []  # velocities that the dampers oppose, (n, 3) per overlap [m/s]
        self.damped = self.approach = 0.0
        self.before: dict[int, Before] = {}
        self._pushes: dict[int, np.ndarray] = {}  # last result of `forces_apart` in this step, see `ContactSurface.pushed`
        self._swings: dict[int, float] = {}

    def begin(self) -> None:
        """Reset the damper forces on flat sides and the oscillation rates due to contact, at the start of a step."""
        self._pushes, self._swings = {}, {}

    def force_on_all(self, overlaps: "Sequence[Overlap]", pressures: Arrays, stiffness: Arrays, dt: float) -> list[np.ndarray]:
        """Return the forces of one common damper over a step of length dt [s], as an array of normal forces on the points
        of each overlap, shape (n,) [N]. They are proportional to `pressures`. The stiffness after the step also increases
        `ContactSurface.swings` of the rigid bodies.

        pressures: spring forces on the points of each overlap, shape (n,) [N]. stiffness: for each overlap, tangent
        stiffness of the springs, shape (2, n) [N/m]: in the first row now (which defines the damper), in the second row
        after the step.
        """
        self._speeds = []
        total = sum(float(pressure.sum()) for pressure in pressures)
        if total <= 0.0:
            return [np.zeros_like(pressure) for pressure in pressures]
        shares = [pressure / total for pressure in pressures]
        self._now = sum(float(share @ _approach(part)) for share, part in zip(shares, overlaps, strict=True))
        now, later = (sum(float(np.sum(of[number])) for of in stiffness) for number in range(2))
        place, normal, mobility = *_places(overlaps), 0.0
        for side in self._rigid:
            way = _signs(side, overlaps) * np.concatenate(shares)[:, None] * normal
            own = side.mobility_along(place, way)
            mobility += _sharing(side.pushed_along, way.sum(axis=0)) * own
            side.swings += later * own
        extra = 0.0
        if mobility > 0.0:
            damper = 2.0 * DEAD * sqrt(now / mobility)
            extra = damper * self._now / (1.0 + damper * mobility * dt)
        return [extra * pressure / total for pressure in pressures]

    def forces_apart(
        self, overlaps: "Sequence[Overlap]", pressures: Arrays, drags: Arrays, friction: float, stiffness: Arrays, dt: float
    ) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Return two lists with one array per overlap, if each point has a damper: normal damper forces, shape (n,), and
        friction forces, shape (n, 3) [N].

        Used for flat sides on planes. The normal damper forces are forces in addition to `pressures`. The forces of other
        contacts of the same bodies in this step are taken into account. drags: forces of the friction springs on the points
        of each overlap [N], shape (n, 3). friction: coefficient of friction. pressures, stiffness, dt: see `force_on_all`.
        """
        place, normal, pressure = *_places(overlaps), np.concatenate(pressures)
        now, later = np.concatenate(stiffness, axis=1)
        speed = -np.concatenate([part.relative for part in overlaps])
        self._speeds = _split(speed, overlaps)
        ways = np.concatenate([normal[None], _tangents(normal)]) if friction > 0.0 else normal[None]
        columns, n, total = list[np.ndarray](), len(pressure), float(now.sum())
        others = np.zeros(n * len(ways))  # changes of the speeds by other contacts
        for side in self._rigid:
            sign = _signs(side, overlaps)
            rows = np.concatenate([side.mobility_rows(place, sign * way) for way in ways])
            self._swings[id(side)] = float(np.linalg.eigvalsh(np.einsum("ni,n,nj->ij", rows[:n], later, rows[:n]))[-1])
            mean = np.einsum("n,nd->d", now, sign * normal) / total
            columns.append(rows if side.stops_at_once else sqrt(_sharing(side.pushed_along, mean)) * rows)
            if side.stops_at_once:
                others += _speeds_by(rows, side.pushed - self._pushes.get(id(side), 0.0))
        rows = np.concatenate(columns, axis=1)
        mobility = float(np.sum((_push_of(rows[:n], now) / total) ** 2))
        if mobility <= 0.0:
            return [np.zeros_like(of) for of in pressures], [np.zeros_like(of) for of in drags]
        damper = 2.0 * DEAD_APART * np.tile(now, len(ways)) / sqrt(mobility * total)
        speeds, held = (np.einsum("nd,knd->kn", of, ways).ravel() for of in (speed, np.concatenate(drags)))
        speeds[:n], held[:n] = np.concatenate([_approach(part) for part in overlaps]), pressure
        sudden = np.maximum(pressure - np.concatenate(self._borne(overlaps)), 0.0)
        speeds -= dt * (others + _speeds_by(rows, _push_of(rows[:n], sudden)))
        force = Dampers(damper, rows, speeds, held, dt).solve(friction, n)
        more = force - held
        more[:n] += sudden
        for side, z in zip(self._rigid, columns, strict=True):
            push = _push_of(z, more)
            side.pushed += push - self._pushes.get(id(side), 0.0)
            self._pushes[id(side)] = push
        drag = np.einsum("kn,knd->nd", force[n:].reshape(-1, n), ways[1:])
        return _split(force[:n] - pressure, overlaps), _split(drag, overlaps)

    def taken(self, given: Arrays, power: float, last: float) -> float:
        """Return the energy that the common damper dissipated in the last step, of length `last` [s], in joules.

        given: damper forces on the points of each overlap, shape (n,) [N]. power: power of the damper at the end of the
        last step [W].

        The dissipated energy is the step length times the mean of the damper forces before and after the step times the
        approach velocity after the step, because force and velocity change considerably in a step.
        """
        energy = 0.5 * last * (self.damped * self._now + power)
        self.damped, self.approach, self.before = sum(float(np.sum(force)) for force in given), self._now, {}
        return energy

    def taken_apart(self, overlaps: "Sequence[Overlap]", given: Arrays, pressed: Arrays, last: float) -> float:
        """Return the energy that the dampers of single points dissipated in the last step [J]; store the damper forces
        `given` of this step for the next call.

        given: damper forces [N], shape (n, 3) per overlap. pressed: spring forces [N], shape (n,) per overlap. last: length
        of the last step [s].
        """
        for side in self._rigid:
            side.swings += self._swings.get(id(side), 0.0)
        work, before, bears = self.damped * self.approach, {}, self._borne(overlaps)
        for part, force, speed, borne, press in zip(overlaps, given, self._speeds, bears, pressed, strict=True):
            number = self._numbers[id(part.one)]
            before[number] = Before(part.listed, force, speed, (1.0 - BEARS) * borne + BEARS * press)
            if number in self.before:
                old = self.before.pop(number)
                now = _at_points(part, old.listed, old.speed)
                now[part.listed] = speed
                work += float(np.sum(old.force * now[old.listed]))
            work += float(np.sum(force * speed))
        work += sum(float(np.sum(old.force * old.speed)) for old in self.before.values())
        self.damped, self.before = 0.0, before
        return 0.5 * last * work

    def end(self, last: float) -> float:
        """Return the energy that the dampers dissipated in the step that ended the contact, of length `last` [s], in
        joules; discard all stored dampers."""
        self._speeds, self._swings = [], {}
        energy = self.taken_apart([], [], [], last)
        self.approach = 0.0
        return energy

    def _borne(self, overlaps: "Sequence[Overlap]") -> list[np.ndarray]:
        """Return the normal force that each point of the overlaps supports [N] (`Before.borne`), one array per overlap; 0
        for points without a damper in the last step."""
        old = [self.before.get(self._numbers[id(part.one)], NOTHING) for part in overlaps]
        return [_at_points(part, of.listed, of.borne)[part.listed] for part, of in zip(overlaps, old, strict=True)]

    def state_numbers(self) -> list[object]:
        """Return the force of the common damper and the dampers of single points in the last step, as lists for a
        checkpoint."""
        kept = {str(number): [values.tolist() for values in old] for number, old in self.before.items()}
        return [self.damped, self.approach, kept]

    def restore(self, numbers: Sequence[Any]) -> None:
        """Restore the dampers, the result of `state_numbers`, from a checkpoint."""
        self.damped, self.approach, kept = numbers
        self.before = {}
        for number, (listed, *values) in kept.items():
            self.before[int(number)] = Before(np.array(listed, np.int64), *(np.array(of, float) for of in values))


class Dampers:
    """Solver for the forces f of pairs of a spring and a parallel damper over a step dt [s], f = s + c (v - Δt A (f - s)),
    with spring forces s [N], dampers c [kg/s] and the velocities v [m/s] that the dampers oppose. Used for one damper per
    point.

    A = rows rowsᵀ is the mobility: the change of the velocities per unit force and unit time. The arguments `damper`,
    `speed` and `held` are c, v and s.
    """

    def __init__(self, damper: np.ndarray, rows: np.ndarray, speed: np.ndarray, held: np.ndarray, dt: float) -> None:
        self._damper, self._rows, self._speed, self._held, self._dt = damper, rows, speed, held, dt
        self._force = held.copy()

    def solve(self, friction: float, n: int) -> np.ndarray:
        """Return the forces along n normals, which are not negative, and both components of n friction forces [N], shape (3n,).

        friction: coefficient of friction; if it is 0, the result has only the n normal forces.
        """
        self._push(n)
        if friction == 0.0:
            return self._force
        at = n + np.arange(2 * n).reshape(2, n)
        for _ in range(MOST_ROUNDS):
            before = self._force[:n].copy()
            self._rub(at, friction * before)
            self._push(n)
            if np.abs(self._force[:n] - before).max(initial=0.0) <= SETTLED * np.abs(before).max(initial=0.0):
                break
        self._rub(at, friction * self._force[:n])
        return self._force

    def _push(self, n: int) -> None:
        """Solve for the n normal forces under the constraint f ≥ 0."""
        free, force = np.ones(n, bool), self._force[:n]
        for _ in range(MOST_ROUNDS):
            force[~free] = 0.0
            self._solve(np.flatnonzero(free))
            change = free & (force < 0.0)
            if not change.any():  # some of the released points may push again
                change = ~free & (self._held[:n] + self._damper[:n] * self._speeds_with_forces(slice(n)) > 0.0)
            if not change.any():
                break
            free ^= change
        np.maximum(force, 0.0, out=force)

    def _rub(self, at: np.ndarray, most: np.ndarray) -> None:
        """Solve for the friction forces of m points: `at` has the indices of their two components, shape (2, m), and `most`
        is the largest friction force of each point [N], shape (m,)."""
        force, free = self._force, most > 0.0
        force[at[:, ~free]] = 0.0
        for _ in range(MOST_ROUNDS):
            self._solve(at[:, free].ravel())
            size = np.linalg.norm(force[at], axis=0)
            slides = free & (size > most)
            if not slides.any():
                break
            force[at[:, slides]] *= most[slides] / size[slides]
            free &= ~slides

    def _solve(self, free: np.ndarray) -> None:
        """Solve the equations of all forces with the indices `free`, and store these forces; all other forces keep their
        values."""
        z, c = self._rows[free], self._damper[free]
        self._force[free] = self._held[free]
        v = self._speeds_with_forces(free)
        inner = np.eye(z.shape[1]) / self._dt + np.einsum("ni,n,nj->ij", z, c, z)
        self._force[free] += c * (v - _speeds_by(z, np.linalg.solve(inner, _push_of(z, c * v))))

    def _speeds_with_forces(self, at: np.ndarray | slice) -> np.ndarray:
        """Return v - Δt A (f - s), the velocities at the end of the step [m/s], at the given indices."""
        push = _push_of(self._rows, self._force - self._held)
        return np.asarray(self._speed[at] - self._dt * _speeds_by(self._rows[at], push))


_push_of = partial(np.einsum, "ni,n->i")  # Σ f z of forces f, with the rows z of `ContactSurface.mobility_rows`
_speeds_by = partial(np.einsum, "ni,i->n")  # change of the speeds per unit of time, from rows and a sum Σ f z


def _places(overlaps: "Sequence[Overlap]") -> tuple[np.ndarray, np.ndarray]:
    """Return the positions [m] and the normals of the points of all overlaps, shape (n, 3) each."""
    places = [part.one.place[part.listed] for part in overlaps]
    return np.concatenate(places), np.concatenate([part.normal for part in overlaps])


def _signs(side: ContactSurface, overlaps: "Sequence[Overlap]") -> np.ndarray:
    """Return the sign of the contact force on surface `side` for each point of all overlaps, shape (n, 1): 1 for points of
    this surface, -1 for points of the surface in contact with it."""
    return np.concatenate([np.full((len(part.listed), 1), 1.0 if part.one is side else -1.0) for part in overlaps])


def _split(values: np.ndarray, overlaps: "Sequence[Overlap]") -> list[np.ndarray]:
    """Split an array with one row for each point of all overlaps into one array per overlap, and return the list."""
    return np.split(values, np.cumsum([len(part.listed) for part in overlaps])[:-1])


def _at_points(part: "Overlap", listed: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return an array with a row for each point of the surface whose overlap is `part`: row k of `values` at the point
    listed[k], zero at points that are not listed."""
    found = np.zeros((len(part.one.place), *values.shape[1:]))
    found[listed] = values
    return found


def _tangents(normal: np.ndarray) -> np.ndarray:
    """Return two unit tangents for each normal, shape (2, n, 3)."""
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normal, first)])


def _sharing(pushed_along: Sequence[np.ndarray], way: np.ndarray) -> float:
    """Return the effective number of contacts, at least 1, that share the mass of a body along the direction `way`, shape
    (3,).

    pushed_along: unit vectors along which the contacts push the body, shape (3,) each.
    """
    return max(1.0, float(sum((along @ way) ** 2 for along in pushed_along)) / max(float(way @ way), 1e-300))


def _approach(part: "Overlap") -> np.ndarray:
    """Return the approach velocity of the two surfaces at each point of an overlap [m/s], shape (n,). Where the surfaces
    face each other, the part of the velocity due to rotation of a body is measured along the normals of this body."""
    approach = -np.einsum("ij,ij->i", part.relative, part.normal)
    if part.one.faces is not None:
        return approach
    own = part.one.normals()[part.listed]
    facing = np.clip((-np.einsum("ij,ij->i", own, part.normal) - ASKEW) / (FACING - ASKEW), 0.0, 1.0)
    by_rotation, n_faces = part.one.turning(part.one.place[part.listed]), len(part.one.place) - part.one.n_edge_points
    turning = facing * np.einsum("ij,ij->i", by_rotation, own + part.normal)
    on_edge = part.listed >= n_faces
    tangent = part.one.edge_tangent[part.listed[on_edge] - n_faces]
    along = np.einsum("ij,ij->i", by_rotation[on_edge], tangent)
    turning[on_edge] = along * np.einsum("ij,ij->i", tangent, part.normal[on_edge])
    return np.asarray(turning + approach)
