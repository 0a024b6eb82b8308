"""Dampers that stop two bodies of which none deforms.

**One damper on the mean approach of all points in contact.** It is so strong compared with what both bodies weigh there that
they hardly rebound: one that is critical and may only push lets go at exp(-2) of the speed of an impact, one of DEAD times
that at 1/(2 DEAD)² in short steps. In the steps of a run a body comes in by up to the way of a step before anything pushes,
and the spring gives some hundredths of the speed back. A step takes the approach as an implicit one would, to 1/(1 + c A Δt)
of it for the damper c and the change A of the approach by an impulse, so that no step is too long for it. A body that others
push along the same way responds to each with its share of the mass.

A body that rolls or glides does not approach, though each of its points may: those ahead go down, those behind up, and with
few points in contact their mean goes to and fro. So where both surfaces face each other the rotation of a body counts by the
velocities along its own normals, with which it brings its surface nearer, a round one not at all; the rest by those along the
normals of the other body, over which it may glide.

**A damper for each point of a flat side on a plane.** A block that begins to tip is carried by one edge at once; with one
damper on the mean approach the middle of its side would carry it first. So the points of bodies that planes bound stop each
by itself: along the normal, where forces only push, and along the surface, where friction limits them. All forces of a step
follow together from f = s + c (v - Δt A (f - s)) with the springs s, the dampers c and the mobility A of the rigid bodies, of
rank 6 or 12.
"""

from collections.abc import Sequence
from math import sqrt
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.contact.contact_surface import ContactSurface

if TYPE_CHECKING:
    from pellucid.contact.overlap import Overlap

DEAD = 8.0  # over what is critical
DEAD_APART = 64.0  # the same of points that stop each by itself
BEARS = 0.2
"""Share of the difference by which the pressure that a point bears follows that of its depth in a step. The rest counts as
stopping the approach: otherwise springs throw back a body that came in by the way of a step."""
MOST_ROUNDS, SETTLED = 20, 1e-3
"""Rounds in which forces that would pull and drags that would be too large are limited; change of the forces over the largest
one that ends them."""
FACING, ASKEW = 0.97, 0.9
"""Cosines of the angle between normals that face each other, from which on they do so wholly, and down to which at all."""


class Before(NamedTuple):
    """Points that stop each by itself as the last step began."""

    listed: np.ndarray  # (n,) which of the surface
    force: np.ndarray  # (n, 3) of the dampers on them [N]
    speed: np.ndarray  # (n, 3) against which these act [m/s]
    borne: np.ndarray  # (n,) the pressure that it bears by now [N]


class DeadStop:
    """The dampers between surfaces, at least one of which belongs to a rigid body whose motion is not all prescribed.

    Attributes
    ----------
    damped, approach : float
        Force of all dampers [N], and the mean approach [m/s], as the last step began.
    before : dict
        `Before` of the points of each surface, by its number.
    """

    def __init__(self, sides: Sequence[ContactSurface]) -> None:
        self._sides = sides
        self._rigid = [side for side in sides if side.rigid_mass < np.inf]
        self._now = 0.0  # mean approach [m/s]
        self._speeds: list[np.ndarray] = []  # of approach and of sliding, against which dampers act (n, 3) [m/s]
        self.damped = self.approach = 0.0
        self.before: dict[int, Before] = {}
        self._pushes: dict[int, np.ndarray] = {}  # what `forces_apart` found last in this step, see `ContactSurface.pushed`
        self._swings: dict[int, float] = {}

    def begin(self) -> None:
        """Begin a step."""
        self._pushes, self._swings = {}, {}

    def force_on_all(
        self,
        overlaps: "Sequence[Overlap]",
        pressures: Sequence[np.ndarray],
        stiffness: Sequence[np.ndarray],
        dt: float,
    ) -> list[np.ndarray]:
        """Return the forces of one damper on the points of overlaps over a step dt [s], shared out as their pressures [N] are.

        stiffness: of each point, now and after the step as it counts in the bound on the step, shape (2, n) [N/m].
        Adds to how fast the bodies swing on what they touch.
        """
        total = sum(float(pressure.sum()) for pressure in pressures)
        extra = self._force_on_all(overlaps, pressures, total, stiffness, dt)
        return [extra * pressure / total if total > 0.0 else np.zeros_like(pressure) for pressure in pressures]

    def _force_on_all(
        self,
        overlaps: "Sequence[Overlap]",
        pressures: Sequence[np.ndarray],
        total: float,
        stiffness: Sequence[np.ndarray],
        dt: float,
    ) -> float:
        """Return the force of a damper on the mean approach, weighted by the pressures [N]."""
        self._speeds = []
        if total <= 0.0:
            return 0.0
        shares = [pressure / total for pressure in pressures]
        self._now = sum(float(share @ _approach(part)) for share, part in zip(shares, overlaps, strict=True))
        now, later = (sum(float(np.sum(of[number])) for of in stiffness) for number in range(2))
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
            side.swings += later * own
        if mobility <= 0.0:
            return 0.0
        damper = 2.0 * DEAD * sqrt(now / mobility)
        return damper * self._now / (1.0 + damper * mobility * dt)

    def forces_apart(
        self,
        overlaps: "Sequence[Overlap]",
        pressures: Sequence[np.ndarray],
        drags: Sequence[np.ndarray],
        friction: float,
        stiffness: Sequence[np.ndarray],
        dt: float,
    ) -> tuple[list[np.ndarray], list[np.ndarray]]:
        """Return the forces of a damper for each point, of flat sides on planes, besides what other contacts push in this step.

        Parameters
        ----------
        overlaps, pressures, stiffness, dt
            See `force_on_all`.
        drags : sequence of ndarray, shape (n, 3)
            Forces of the springs of friction on the points [N].
        friction : float
            Coefficient of friction.

        Returns
        -------
        tuple
            Forces along the normals besides the pressures, shape (n,), and drags of friction, shape (n, 3), of each overlap
            [N].
        """
        normal = np.concatenate([part.normal for part in overlaps])
        place = np.concatenate([part.one.place[part.listed] for part in overlaps])
        pressure, spring = np.concatenate(pressures), np.concatenate(drags)
        now, later = np.concatenate(stiffness, axis=1)
        speed = -np.concatenate([part.relative for part in overlaps])
        self._speeds = _split(speed, overlaps)
        ways = np.concatenate([normal[None], _tangents(normal)]) if friction > 0.0 else normal[None]
        columns, n, total = list[np.ndarray](), len(pressure), float(now.sum())
        others = np.zeros(n * len(ways))
        for side in self._rigid:
            sign = np.concatenate([np.full(len(part.listed), 1.0 if part.one is side else -1.0) for part in overlaps])[:, None]
            rows = np.concatenate([side.mobility_rows(place, sign * way) for way in ways])
            along = rows[:n]
            self._swings[id(side)] = float(np.linalg.eigvalsh(np.einsum("ni,n,nj->ij", along, later, along))[-1])
            mean = np.einsum("n,nd->d", now, sign * normal) / total
            columns.append(rows if side.stops_at_once else sqrt(_sharing(side.pushed_along, mean)) * rows)
            if side.stops_at_once:
                others += np.einsum("ni,i->n", rows, side.pushed - self._pushes.get(id(side), 0.0))
        rows = np.concatenate(columns, axis=1)
        mobility = float(np.sum((np.einsum("n,ni->i", now, rows[:n]) / total) ** 2))
        if mobility <= 0.0:
            return [np.zeros_like(of) for of in pressures], [np.zeros_like(of) for of in drags]
        damper = 2.0 * DEAD_APART * np.tile(now, len(ways)) / sqrt(mobility * total)
        speeds = np.einsum("nd,knd->kn", speed, ways).ravel()
        speeds[:n] = np.concatenate([_approach(part) for part in overlaps])
        held = np.einsum("nd,knd->kn", spring, ways).ravel()
        held[:n] = pressure
        sudden = np.maximum(pressure - np.concatenate(self._borne(overlaps)), 0.0)
        speeds -= dt * (others + np.einsum("ni,i->n", rows, np.einsum("ni,n->i", rows[:n], sudden)))
        force = forces_of(Dampers(damper, rows, speeds, held, dt), friction, n)
        more = force - held
        more[:n] += sudden
        for side, z in zip(self._rigid, columns, strict=True):
            push = np.einsum("ni,n->i", z, more)
            side.pushed += push - self._pushes.get(id(side), 0.0)
            self._pushes[id(side)] = push
        drag = np.einsum("kn,knd->nd", force[n:].reshape(-1, n), ways[1:])
        return _split(force[:n] - pressure, overlaps), _split(drag, overlaps)

    def taken(self, given: Sequence[np.ndarray], power: float, last: float) -> float:
        """Return the energy that dampers took over the last step [J], which lasted so long [s].

        given: their forces on the points [N]; power: what they take as it ends [W].

        The work of contact counts the mean of the velocities before and after a step: of a damper F it is that of the mean of
        the forces before and after on the velocity after, where F and v change by much in a step.
        """
        damped = sum(float(np.sum(force)) for force in given)
        energy = 0.5 * last * (self.damped * self._now + power)
        self.damped, self.approach, self.before = damped, self._now, {}
        return energy

    def taken_apart(
        self, overlaps: "Sequence[Overlap]", given: Sequence[np.ndarray], pressed: Sequence[np.ndarray], last: float
    ) -> float:
        """Return the energy that the dampers of single points took over the last step [J].

        given: forces of the dampers [N], shape (n, 3); pressed: pressures of the depths [N], shape (n,).
        """
        for side in self._rigid:
            side.swings += self._swings.get(id(side), 0.0)
        work, before = self.damped * self.approach, {}
        bears = [(1.0 - BEARS) * old + BEARS * press for old, press in zip(self._borne(overlaps), pressed, strict=True)]
        for number, part, force, speed, borne in zip(
            self._numbers(overlaps), overlaps, given, self._speeds, bears, strict=True
        ):
            before[number] = Before(part.listed, force, speed, borne)
            if number in self.before:
                old = self.before.pop(number)
                now = np.zeros((len(part.one.place), 3))
                now[old.listed] = old.speed
                now[part.listed] = speed
                work += float(np.sum(old.force * now[old.listed]))
            work += float(np.sum(force * speed))
        work += sum(float(np.sum(old.force * old.speed)) for old in self.before.values())
        self.damped, self.before = 0.0, before
        return 0.5 * last * work

    def _numbers(self, overlaps: "Sequence[Overlap]") -> list[int]:
        """Return the index of the surface to which the points of each overlap belong."""
        numbers = {id(side): number for number, side in enumerate(self._sides)}
        return [numbers[id(part.one)] for part in overlaps]

    def _borne(self, overlaps: "Sequence[Overlap]") -> list[np.ndarray]:
        """Return the force that each point bore at the start of the last step [N]."""
        found = []
        for number, part in zip(self._numbers(overlaps), overlaps, strict=True):
            borne = np.zeros(len(part.one.place))
            if number in self.before:
                borne[self.before[number].listed] = self.before[number].borne
            found.append(borne[part.listed])
        return found

    def end(self, last: float) -> float:
        """Return the energy [J] that the dampers took over the step in which contact ended, and forget them."""
        energy = 0.5 * last * self.damped * self.approach
        energy += 0.5 * last * sum(float(np.sum(old.force * old.speed)) for old in self.before.values())
        self.damped = self.approach = 0.0
        self.before = {}
        return energy

    def state_numbers(self) -> list[object]:
        """Return the state for a checkpoint."""
        kept = {str(number): [values.tolist() for values in old] for number, old in self.before.items()}
        return [self.damped, self.approach, kept]

    def restore(self, numbers: Sequence[Any]) -> None:
        """Go on from a checkpoint."""
        self.damped, self.approach, kept = numbers
        self.before = {}
        for number, (listed, *values) in kept.items():
            self.before[int(number)] = Before(np.array(listed, np.int64), *(np.array(of, float) for of in values))


def _split(values: np.ndarray, overlaps: "Sequence[Overlap]") -> list[np.ndarray]:
    """Split the values of all points by overlap."""
    return np.split(values, np.cumsum([len(part.listed) for part in overlaps])[:-1])


def _tangents(normal: np.ndarray) -> np.ndarray:
    """Return two unit tangents for each normal, shape (2, n, 3)."""
    axis = np.eye(3)[np.abs(normal).argmin(axis=1)]
    first = np.cross(normal, axis)
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(normal, first)])


class Dampers:
    """Forces f = s + c (v - Δt A (f - s)) of springs s [N] and dampers c [kg/s] against speeds v [m/s]; A = rows rowsᵀ: what
    forces change of the speeds in a unit of time."""

    def __init__(self, damper: np.ndarray, rows: np.ndarray, speed: np.ndarray, held: np.ndarray, dt: float) -> None:
        self._damper, self._rows, self._speed, self._held, self._dt = damper, rows, speed, held, dt
        self.force = held.copy()

    def solve(self, free: np.ndarray) -> None:
        """Solve for the forces with the given indices; the others keep their values."""
        force, held, z, c = self.force, self._held, self._rows[free], self._damper[free]
        force[free] = held[free]
        v = self._speed[free] - self._dt * self._change(z)
        inner = np.eye(z.shape[1]) / self._dt + np.einsum("ni,n,nj->ij", z, c, z)
        force[free] += c * (v - np.einsum("ni,i->n", z, np.linalg.solve(inner, np.einsum("ni,n->i", z, c * v))))

    def wanted(self, n: int) -> np.ndarray:
        """Return the forces along the n normals, without a limit, for the present forces of all others [N]."""
        v = self._speed[:n] - self._dt * self._change(self._rows[:n])
        return np.asarray(self._held[:n] + self._damper[:n] * v)

    def _change(self, z: np.ndarray) -> np.ndarray:
        """Return the rate of change of the speeds with rows z by all forces except the springs [m/s²]."""
        return np.asarray(np.einsum("ni,i->n", z, np.einsum("ni,n->i", self._rows, self.force - self._held)))

    def push_alone(self, n: int) -> None:
        """Solve for the forces along the n normals, which only push: f ≥ 0."""
        free = np.ones(n, bool)
        for _ in range(MOST_ROUNDS):
            self.force[:n][~free] = 0.0
            self.solve(np.flatnonzero(free))
            pulls = free & (self.force[:n] < 0.0)
            back = ~free & (self.wanted(n) > 0.0) if not pulls.any() else np.zeros(n, bool)
            if not pulls.any() and not back.any():
                break
            free = (free & ~pulls) | back
        np.maximum(self.force[:n], 0.0, out=self.force[:n])

    def rub(self, at: np.ndarray, most: np.ndarray) -> None:
        """Find pairs of forces at indices of shape (2, m), none larger than most [N]."""
        free = most > 0.0
        self.force[at[:, ~free]] = 0.0
        for _ in range(MOST_ROUNDS):
            self.solve(at[:, free].ravel())
            size = np.linalg.norm(self.force[at], axis=0)
            slides = free & (size > most)
            if not slides.any():
                break
            self.force[at[:, slides]] *= most[slides] / size[slides]
            free &= ~slides


def forces_of(dampers: Dampers, friction: float, n: int) -> np.ndarray:
    """Return the forces along n normals, which only push, followed by both components of n drags, limited by friction [N]."""
    dampers.push_alone(n)
    if friction == 0.0:
        return dampers.force
    at = n + np.arange(2 * n).reshape(2, n)
    for _ in range(MOST_ROUNDS):
        before = dampers.force[:n].copy()
        dampers.rub(at, friction * before)
        dampers.push_alone(n)
        if np.abs(dampers.force[:n] - before).max(initial=0.0) <= SETTLED * np.abs(before).max(initial=0.0):
            break
    dampers.rub(at, friction * dampers.force[:n])
    return dampers.force


def _sharing(pushed_along: Sequence[np.ndarray], way: np.ndarray) -> float:
    """Return the number of contacts, at least 1, among which a body shares its mass along a direction, (3,).

    pushed_along: unit vectors along which contacts push the body, (3,) each.
    """
    return max(1.0, float(sum((along @ way) ** 2 for along in pushed_along)) / max(float(way @ way), 1e-300))


def _approach(part: "Overlap") -> np.ndarray:
    """Return the speed of approach of both surfaces at each point [m/s], shape (n,)."""
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
