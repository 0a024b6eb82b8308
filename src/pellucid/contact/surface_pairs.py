"""Contact between surfaces: forces of their overlap, friction, and damping of what vibrates as fast as a cell.

Each point of either surface that lies in the other is pushed out by the pressure κ d of its depth d. The forces of such a
pressure are those of an energy, ½ Σ κ a d²: what glides or rolls gets back behind the place of contact what it gave ahead of
it, where an impulse that stops an approach gives nothing back. 1/κ is the sum of both sides' compliance, that of a layer of
the surface which swings at the fastest rate that the step of its body allows, so that contact bounds no step.

Friction is a spring along the surface that slides where its force would be more than μ times the pressure (Coulomb); a contact
that sticks has no limit. Both surfaces are asked, each with a share of the stiffness that grows with how fine it is: the points
of a coarse surface are a bed of nails for a fine one.

A damper in parallel takes a tenth of what is critical for the masses of the two layers: it ends their vibrations within some
of their periods, and hardly acts on bodies as a whole. Bodies of which none deforms do not rebound: a second damper, critical
for their masses, acts on the mean approach of all points in contact. What rolls has none.
"""

from collections.abc import Sequence
from math import sqrt

import numpy as np

from pellucid.contact import proximity
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Described, Plane, describe
from pellucid.contact.proximity import CHUNK, COLUMNS, GAP, NORMAL, SHARE, Bins, Meeting, Points

STIFF, DAMPING = 1.0, 0.1
"""How fast the layer of a body that touches swings, over its step: from two on it would go out of bounds. What the damper takes
of what is critical for the masses of the layers."""
SINK, IMPACT = 3e-4, 0.2
"""Cells: how far a rigid body sinks into another that does not deform either, lying with all of its side on it, and striking it
so with the speeds of the start."""
RESOLVED = 0.6  # of how fast a rigid body swings then, which bounds its step as waves do that of others: mostly less touches
STICKS = 1e12  # coefficient of friction of what sticks while it presses


class Pass:
    """The points of one surface against the other, with this share of the stiffness."""

    def __init__(self, one: ContactSurface, other: ContactSurface, meeting: Meeting, share: float) -> None:
        self.one, self.other, self._meeting, self.share = one, other, meeting, share
        self._found = np.zeros((len(one.place), COLUMNS))

    def find(self, one: Described, other: Described) -> bool:
        """Find the points of the one surface that overlap with the other; whether there are any."""
        m = len(self.one.place)
        self._points = one.place[:m], one.normal[:m]
        self._beside = Points(other.place, other.normal, other.size, other.reach)
        self._bins = _bins(self.one.place, other.place, float(other.reach.max()))
        self.listed = np.zeros(0, np.int64)
        if self._bins is None:
            return False
        proximity.find_beside(m // CHUNK + 1, self._points, self._beside, self._bins, self._meeting, self._found)
        gap = self._found[:, GAP] - self.one.half_width - self.other.half_width
        self.listed = at = np.flatnonzero((self._found[:, SHARE] > 0.0) & (gap < 0.0))
        if not len(at):
            return False
        self.depth, self.normal = -gap[at], self._found[at, NORMAL : NORMAL + 3]
        self.area = self._found[at, SHARE] * one.size[at]
        carried = np.empty((len(at), 3))
        proximity.mean_velocities(at, *self._about(), other.velocity, carried)
        self.relative = one.velocity[at] - carried
        return True

    def _about(self) -> tuple[object, ...]:
        return self._points, self._beside, self._bins, self._meeting, self._found

    def give(self, force: np.ndarray, forces: tuple[np.ndarray, np.ndarray]) -> None:
        """Forces on the listed points [N], shape (n, 3), and against the other surface, into those of both."""
        forces[0][self.listed] += force
        proximity.spread_forces(self.listed, *self._about(), -force, forces[1])


class SurfacePair:
    """Two surfaces that touch.

    friction: coefficient μ, `STICKS` where they stick while they press. dimension: of the surfaces, 2, in the plane 1, along a
    line 0; thickness: of a slice [m]. courant: of the case's `time`. swing: how fast bodies that do not deform are to swing on
    each other [1/s], see `swing_of`; 0 where nothing moves them, and their materials tell.
    """

    def __init__(
        self,
        surfaces: tuple[ContactSurface, ContactSurface],
        friction: float,
        dimension: int,
        thickness: float,
        courant: float,
        swing: float = 0.0,
        name: str | None = None,
    ) -> None:
        one, other = self.surfaces = surfaces
        self.name, self._friction = name, friction
        self._hard = one.is_hard and other.is_hard
        self._mass = 1.0 / max(sum(1.0 / surface.rigid_mass for surface in surfaces), 1e-300)
        soft = [surface for surface in surfaces if self._hard or not surface.is_hard]
        fastest = STIFF / courant
        self._stiffness = 1.0 / sum(1.0 / (surface.mass_per_area * (fastest * surface.rate) ** 2) for surface in soft)
        rigid = [surface for surface in surfaces if surface.rigid_mass < np.inf]
        if self._hard and rigid and swing > 0.0:
            self._stiffness = swing**2 * self._mass / max(surface.side() for surface in rigid)
        self._damping = 2.0 * DAMPING * sqrt(self._stiffness / sum(1.0 / surface.mass_per_area for surface in soft))
        for surface in rigid:
            swings = sqrt(self._stiffness * surface.side() / self._mass)
            surface.contact_rate = max(surface.contact_rate, RESOLVED * swings)
        fine = [1.0 / float(np.median(surface.reach)) ** 2 for surface in surfaces]
        self._passes = []
        for first, second, share in ((one, other, fine[0]), (other, one, fine[1])):
            meeting = Meeting((first.two_sided, second.two_sided), _deepest(second), dimension, thickness)
            self._passes.append(Pass(first, second, meeting, share / sum(fine)))
        self.impulse = np.zeros(3)
        """On the first surface over this step [N s]."""
        self.stored = 0.0
        """Energy of the overlap [J]."""

    def find(self, described: dict[int, Described]) -> bool:
        """Find where they overlap; whether they do. described: the points of surfaces, by identity."""
        self.impulse = np.zeros(3)
        self.stored = 0.0
        found = False
        for part in self._passes:
            found |= part.find(described[id(part.one)], described[id(part.other)])
        return found

    def push(self, dt: float, last: float, forces: dict[int, np.ndarray], touched: dict[int, np.ndarray]) -> None:
        """Add the forces of the overlap over a step dt [s] to those of the surfaces; last: length of the step before."""
        active = [part for part in self._passes if len(part.listed)]
        pressures = [part.share * self._stiffness * part.area * part.depth for part in active]
        extra = self._mean_damping(active, pressures) if self._hard else 0.0
        total = sum(float(pressure.sum()) for pressure in pressures)
        for part, pressure in zip(active, pressures, strict=True):
            n, at, one = part.normal, part.listed, part.one
            approach = -np.einsum("ij,ij->i", part.relative, n)
            damping = part.share * self._damping * part.area
            press = np.maximum(pressure + damping * approach + extra * pressure / total, 0.0)
            force = press[:, None] * n
            if self._friction > 0.0:
                along = part.relative + approach[:, None] * n
                carried = one.slip[at]
                carried = carried - np.einsum("ij,ij->i", carried, n)[:, None] * n + last * along
                spring = part.share * self._stiffness * part.area
                drag = -spring[:, None] * carried - damping[:, None] * along
                size, most = np.linalg.norm(drag, axis=1), self._friction * press
                slides = size > most
                drag[slides] *= (most[slides] / size[slides])[:, None]
                one.slip[at] = np.where(slides[:, None], _held(carried, spring, most), carried)
                touched[id(one)][at] = True
                force += drag
            part.give(force, (forces[id(one)], forces[id(part.other)]))
            self.stored += 0.5 * float(np.sum(pressure * part.depth))
            self.impulse += (1.0 if one is self.surfaces[0] else -1.0) * dt * force.sum(axis=0)

    def _mean_damping(self, active: Sequence[Pass], pressures: Sequence[np.ndarray]) -> float:
        """The force of the second damper, by the mean approach under these pressures [N]."""
        approach = stiffness = total = 0.0
        for part, pressure in zip(active, pressures, strict=True):
            total += float(pressure.sum())
            approach -= float(np.sum(pressure * np.einsum("ij,ij->i", part.relative, part.normal)))
            stiffness += part.share * self._stiffness * float(part.area.sum())
        return 2.0 * sqrt(stiffness * self._mass) * approach / total if total > 0.0 else 0.0


def _held(carried: np.ndarray, spring: np.ndarray, most: np.ndarray) -> np.ndarray:
    """What a spring keeps of how far it was carried where its force is limited."""
    size = np.linalg.norm(carried, axis=1)
    longest = np.where(spring > 0.0, most / np.where(spring > 0.0, spring, 1.0), 0.0)
    return np.asarray(carried * np.minimum(1.0, longest / np.maximum(size, 1e-300))[:, None])


def _deepest(surface: ContactSurface) -> float:
    """How deep a place may lie behind a point of a surface that still counts [m]: less than half through a body."""
    extent = np.ptp(surface.place, axis=0)
    thick = extent[extent > 1e-3 * extent.max()].min(initial=np.inf)
    reach = float(np.median(surface.reach))
    return reach if surface.two_sided else min(reach, 0.4 * float(thick))


def _bins(one: np.ndarray, other: np.ndarray, reach: float) -> Bins | None:
    """The points of the other surface that may lie beside points of the one, by boxes; None where there are none."""
    lower, upper = one.min(axis=0) - reach, one.max(axis=0) + reach
    lower, upper = np.maximum(lower, other.min(axis=0)), np.minimum(upper, other.max(axis=0))
    if (lower > upper).any():
        return None
    size = reach
    counts = np.floor((upper - lower) / size).astype(np.int64) + 1
    while np.prod(counts) > 8 * len(other) + 1000:
        size *= 2.0
        counts = np.floor((upper - lower) / size).astype(np.int64) + 1
    first, order = np.zeros(int(np.prod(counts)) + 1, np.int64), np.zeros(len(other), np.int64)
    shape = int(counts[0]), int(counts[1]), int(counts[2])
    proximity.count_boxes(other, lower, size, shape, np.empty(len(other), np.int64), first, order)
    return Bins(lower, size, shape, first, order)


def swing_of(cell: float, gravity: float, speed: float) -> float:
    """How fast bodies that do not deform are to swing on each other [1/s], for cells [m], gravity [m/s²] and speeds [m/s]."""
    return max(sqrt(gravity / (SINK * cell)), speed / (IMPACT * cell))


class SurfacePairs:
    """All pairs of surfaces of a simulation."""

    def __init__(self, pairs: Sequence[SurfacePair], planes: Sequence[Plane] = ()) -> None:
        """planes: of symmetry."""
        self._pairs, self._planes = pairs, planes
        self._surfaces = list({id(surface): surface for pair in pairs for surface in pair.surfaces}.values())

    def __len__(self) -> int:
        return len(self._pairs)

    def act(self, dt: float, last: float) -> None:
        """Give the bodies the forces of contact over a step dt [s]; last: length of the step before [s]."""
        described, forces, touched = dict[int, Described](), dict[int, np.ndarray](), dict[int, np.ndarray]()
        for surface in self._surfaces:
            surface.begin()
            described[id(surface)] = describe(surface, self._planes)
            touched[id(surface)] = np.zeros(len(surface.place), bool)
        for pair in self._pairs:
            if pair.find(described):
                for surface in pair.surfaces:
                    forces.setdefault(id(surface), np.zeros_like(described[id(surface)].place))
                pair.push(dt, last, forces, touched)
        for surface in self._surfaces:
            surface.slip[~touched[id(surface)]] = 0.0
            if id(surface) in forces:
                surface.add_forces(described[id(surface)].fold(forces[id(surface)]))

    def impulses(self) -> dict[str, np.ndarray]:
        """On the first body of each pair with a name over this step [N s], (3,)."""
        total: dict[str, np.ndarray] = {}
        for pair in self._pairs:
            if pair.name is not None:
                total[pair.name] = total.get(pair.name, np.zeros(3)) + pair.impulse
        return total
