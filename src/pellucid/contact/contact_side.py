"""Contact sides, i.e. points of a surface that lie inside another surface or behind a wall, contacts made of sides, and the
detection of the overlap of the points of one surface with another surface."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pellucid.contact import proximity
from pellucid.contact.contact_surface import FULL_CONTACT, NO_CONTACT, ContactSurface
from pellucid.contact.dead_stop import ASKEW, FACING
from pellucid.contact.following import Following
from pellucid.contact.frozen import Beneath, FrozenSide
from pellucid.contact.images import NO_IMAGES, Described, Feet, Images, Seam
from pellucid.contact.implicit import Block, NormalForces
from pellucid.contact.leads import ContactLead
from pellucid.contact.overlap import Implicit, Overlap, OverlapLaw, StartOverlap, rests_on_flat_side, stop_apart
from pellucid.contact.proximity import CHUNK, Asking, Meeting, Neighbourhood, Points
from pellucid.contact.touch import Touch
from pellucid.jit.bundle import Bundle


class PreviousForces:
    """Store of the damper and friction forces on contact points in the last step, with the feet of these points
    (projections on the other surface). With an implicit contact law, the forces are friction minus normal force.

    In a step Δt, the forces dissipate the energy -½ Δt (F + F')·v', with the forces F before and F' after the step and the
    relative velocities v' after the step. The power F·v' of the stored forces is therefore computed in the next step
    (`power`).
    """

    def __init__(self) -> None:
        self._listed, self._force = np.zeros(0, np.int64), np.zeros((0, 3))
        self._before, self._pressed = self._listed, self._force
        self._feet: Feet | None = None
        self._images = NO_IMAGES

    def store(self, listed: np.ndarray, force: np.ndarray, feet: Feet | None = None, images: Images | None = NO_IMAGES) -> None:
        """Store the forces of this step [N], shape (n, 3), on the points of the surface with the indices `listed`.

        feet: feet of the points, as weights of the points and images of another surface; None for a wall. images: images of
        this surface.
        """
        self._listed, self._force, self._feet = listed, force, feet
        if feet is not None and images is not None:
            self._images = Images(images.point.copy(), images.flip.copy())

    def discard(self) -> np.ndarray:
        """Mark the stored forces as forces of an earlier step: from then on only `pressed` uses them, and `power` is 0
        until the next call of `store`. Return the indices of the points that had forces."""
        listed = self._before = self._listed
        self._pressed = self._force
        self.store(self._listed[:0], self._force[:0])
        return listed

    def pressed(self, overlap: Overlap) -> np.ndarray:
        """Return the implicit normal forces of the previous step on the points of an overlap [N], shape (n,), positive for
        pressure; 0 for points without a stored force.

        The stored forces are friction minus normal force (see `find_point_forces`); this function reverses the sign.
        """
        listed = overlap.listed
        if not len(self._before):
            return np.zeros(len(listed))
        at = np.minimum(np.searchsorted(self._before, listed), len(self._before) - 1)
        press = -np.einsum("ij,ij->i", self._pressed[at], overlap.normal)
        return np.where(self._before[at] == listed, np.maximum(press, 0.0), 0.0)

    def power(self, velocity: np.ndarray, of_other: np.ndarray) -> float:
        """Return the power of the stored forces [W] at the given velocities of the points relative to their feet.

        velocity: velocities of the points of the surface [m/s]. of_other: velocities of the points of the other surface,
        shape (q, 3), or the velocity of a wall, shape (3,), if there are no feet [m/s].
        """
        if not len(self._listed):
            return 0.0
        of_other = of_other if self._feet is None else self._feet.gather(of_other, self._images)
        return float(np.sum(self._force * (velocity[self._listed] - of_other)))

    def state_numbers(self) -> list[object]:
        """Return the stored forces, their points and their feet, for a checkpoint."""
        feet = None if self._feet is None else [part.tolist() for part in self._feet]
        return [self._listed.tolist(), self._force.tolist(), feet, [part.tolist() for part in self._images]]

    def restore(self, numbers: Sequence[Any]) -> None:
        """Restore the forces, the result of `state_numbers`, from a checkpoint."""
        listed, force, feet, (point, flip) = numbers
        self._listed, self._force = np.array(listed, np.int64), np.reshape(np.array(force, float), (-1, 3))
        self._feet = None
        if feet is not None:
            self._feet = Feet(np.array(feet[0], np.int64), np.array(feet[1], np.int64), np.array(feet[2], float))
        self._images = Images(np.array(point, np.int64), np.reshape(np.array(flip, float), (-1, 3)))


class ContactSide(ABC):
    """Points of a surface that may lie inside another surface or behind a wall.

    Attributes
    ----------
    one, other : ContactSurface
        Surface of the points, and the other surface; None for a wall.
    start : StartOverlap
        Initial overlap, which exerts no pressure; None between bodies that do not deform.
    share : float
        Fraction of the contact stiffness that this side has.
    overlap : Overlap
        Overlapping points; None if no point overlaps.
    feet, images : Feet, Images
        Feet of the overlapping points on the other surface, None for a wall, and the images of the other surface.
    pushed : ndarray
        Indices of the points that had forces in the last step, in ascending order.
    lead : ContactLead
        Leads: distances ahead of the surface at which contact acts, which remove the overlap in steady states; None
        on sides without leads.
    lent : float
        Energy that the overlap gained in this step through changes of the leads, divided by the contact stiffness of this
        side [m³].
    """

    def __init__(self, one: ContactSurface, other: ContactSurface | None, start: StartOverlap | None, share: float) -> None:
        self.one, self.other, self.start, self.share = one, other, start, share
        self.overlap: Overlap | None = None
        self.feet: Feet | None = None
        self.images = NO_IMAGES
        self.lead: ContactLead | None = None
        self.keeps_near = False
        """True to keep points across a gap among the overlapping points, for the search of an equilibrium."""
        self.lent, self.pushed, self.given = 0.0, np.zeros(0, np.int64), PreviousForces()

    @abstractmethod
    def find(self, described: Mapping[int, Described], step: float, ahead: bool) -> Overlap | None:
        """Return the overlapping points; None if no point overlaps.

        described: points and images of each surface, by the `id` of the surface. step: length of this step or of the previous
        step, whichever is longer [s]. ahead: True to include also points that would enter within the next steps and points that
        had forces in the previous step.
        """

    @property
    @abstractmethod
    def other_velocity(self) -> np.ndarray:
        """Velocities of the points of the other surface, shape (q, 3), or of the wall, shape (3,) [m/s]."""

    def remove_overlap(self) -> None:
        """Add a contact lead (see `pellucid.contact.leads`) to this side, which removes the overlap in steady
        states."""
        self.lead, self.share = ContactLead(self.one), 1.0

    def apply(self, overlap: Overlap, force: np.ndarray, forces: Mapping[int, np.ndarray]) -> None:
        """Add the forces on the overlapping points [N], shape (n, 3), to the force array of their surface, and the opposite
        forces to the force array of the other surface. forces: force arrays of the surfaces, by the `id` of the surface."""
        forces[id(self.one)][overlap.listed] += force
        if self.other is not None and self.feet is not None:
            self.feet.spread(-force, forces[id(self.other)])


class PointContact(Touch):
    """Contact of the points of surfaces with other surfaces or a wall; forces follow from an `OverlapLaw`.

    sides: for each surface that searches, its points and the surface or wall in contact. surfaces, law, name: see `Touch`.
    """

    def __init__(
        self, surfaces: Sequence[ContactSurface], law: OverlapLaw, sides: Sequence[ContactSide], name: str | None
    ) -> None:
        super().__init__(surfaces, law, name)
        self.sides = list(sides)
        self._described: Mapping[int, Described] = {}

    def find(self, described: dict[int, Described]) -> bool:
        self._described = described
        self.impulse, self.before, self.law.lent = np.zeros(3), 0.0, 0.0
        for side in self.sides:
            self.before += side.given.power(side.one.velocity, side.other_velocity)
            side.pushed, side.lent = side.given.discard(), 0.0
            side.overlap = side.find(described, self.step, self.law.is_implicit)
            self.law.lent += side.share * self.law.stiffness * side.lent
        return any(side.overlap is not None for side in self.sides)

    def freeze(self, described: dict[int, Described], slips: Mapping[int, np.ndarray], dt: float) -> list[FrozenSide]:
        for side in self.sides:
            side.keeps_near = True
        self.find(described)
        found = [(side, side.overlap) for side in self.sides if side.overlap is not None]
        for side in self.sides:
            side.keeps_near = False
        how = self.law.stiffness, self.law.friction
        return [
            FrozenSide(side.one, overlap, _beneath(side), *how, side.lead, slips[id(side.one)], dt) for side, overlap in found
        ]

    def overlaps(self) -> list[Overlap]:
        return [side.overlap for side in self.sides if side.overlap is not None]

    def start_overlaps(self) -> list[StartOverlap]:
        return [side.start for side in self.sides if side.start is not None]

    def previous_forces(self) -> list[PreviousForces]:
        return [side.given for side in self.sides]

    def leads(self) -> list[ContactLead]:
        return [side.lead for side in self.sides if side.lead is not None]

    def begin_steady(self) -> None:
        super().begin_steady()
        self.law.is_implicit = False  # leads remove the overlap

    def push(self, dt: float, last: float, forces: dict[int, np.ndarray], touched: dict[int, np.ndarray]) -> None:
        touching = [(side, side.overlap) for side in self.sides if side.overlap is not None]
        overlaps = [overlap for _, overlap in touching]
        implicit: list[Implicit] = []
        if self.law.is_implicit:
            k = self.law.normal_stiffness
            blocks = [
                Block(overlap, k(overlap), side.given.pressed(overlap), side.other, side.images, side.feet)
                for side, overlap in touching
            ]
            implicit = NormalForces(blocks, dt, self._described, forces).solve()
        found = self.law.forces(overlaps, dt, last, touched, self.before, implicit)
        if self.law.counts_both_ends:
            for (side, overlap), given in zip(touching, self.law.given, strict=True):
                side.given.store(overlap.listed, given, side.feet, side.images)
        for (side, overlap), force in zip(touching, found, strict=True):
            side.apply(overlap, force, forces)
            self.impulse += (1.0 if side.one is self.surfaces[0] else -1.0) * dt * force.sum(axis=0)


def _beneath(side: ContactSide) -> Beneath | None:
    """Return the feet of the points of a side on the other surface; None for a wall."""
    return None if side.other is None or side.feet is None else Beneath(side.other, side.feet, side.images)


RIM = 0.01  # largest distance of a resting edge beyond the rim of a plane, in reaches of a point
SLACK = 0.1  # depth that counts as zero in a steady state, in reaches of the points of the other surface
NEAR = 0.1  # search distance above a deforming surface, in reaches of its points
ROOM = 1.5  # size of arrays over the number of points, so that few searches need new arrays


class SurfaceSide(ContactSide):
    """Points of one surface that may overlap with another surface (`other`); `share` is their fraction of the stiffness.

    meeting: parameters of the contact. by_edges: True to include edge points, for bodies that do not deform; edge points have
    the full stiffness. seams: seams of a periodic grid. ahead: True if the contact law is implicit initially.
    """

    other: ContactSurface

    def __init__(
        self,
        one: ContactSurface,
        other: ContactSurface,
        meeting: Meeting,
        share: float,
        by_edges: bool = False,
        seams: Sequence[Seam] = (),
        ahead: bool = False,
    ) -> None:
        start = None if one.is_hard and other.is_hard else StartOverlap(float(other.reach.max()))
        super().__init__(one, other, start, share)
        self._meeting, self._seams = meeting, seams
        self._n_faces = len(one.place) - one.n_edge_points
        self._counts = np.ones(len(one.place))
        self._counts[self._n_faces :] = 1.0 / share if by_edges else 0.0
        self._apart = by_edges and stop_apart(one, other)
        self._corners = None
        if by_edges and other.faces is not None and not one.two_sided:
            self._corners = np.unique(other.faces[other.faces >= 0])
        self._following = Following(other, float(np.max(one.half_width + other.half_width)))
        # depths of a sheet on a deforming body are third-order distances: feet would lie deeper by a part of the thickness
        self._from_feet = not (other.is_hard or one.is_sheet)
        near = NEAR * float(np.median(other.reach))
        self._near = near if self._from_feet or ahead else 0.0
        self._about: Bundle | None = None
        self._arrays: tuple[np.ndarray, ...] = ()
        self._found = Bundle(proximity.make_room(0, 0))

    @property
    def deepest(self) -> float:
        """Largest depth at which a point counts as in contact [m]."""
        return self._meeting.deepest

    def remove_overlap(self) -> None:
        super().remove_overlap()
        self._near = float(np.median(self.one.reach))  # points across a gap count in the mean overlap too
        # with vanishing overlaps, points under pressure alternate between both sides of the plane of the nearest point
        self._meeting = self._meeting._replace(slack=SLACK * float(np.median(self.other.reach)))
        self._about = None

    @property
    def other_velocity(self) -> np.ndarray:
        return self.other.velocity

    def find(self, described: Mapping[int, Described], step: float, ahead: bool) -> Overlap | None:
        if self._corners is not None:
            return self._find_within_planes(self._corners)
        one, other, before = described[id(self.one)], described[id(self.other)], self._following.candidates
        self.images = other.images
        may = self._following.find(len(self.one.place), one, other, (self.one.stands, self.other.stands))
        if self._following.candidates is not before:
            n, k = len(self._following.candidates.asks), self._following.n_near
            if n > len(self._found.listed) or k > len(self._found.weight):
                self._found = Bundle(proximity.make_room(int(ROOM * n), int(ROOM * k)))
        n, found = self._measure(one, other) if may else 0, self._found
        if self.start is not None:
            found.depth[:n] = self.start.reduce(found.depth[:n])
        if self.lead is not None:
            found.depth[:n], self.lent = self.lead.applied(found.listed[:n], found.depth[:n], found.area[:n])
        if self.keeps_near:
            k = int(found.first[n])
        else:
            n, k = proximity.keep_touching(found, n, self.pushed, step, ahead) if n else (0, 0)
        if not n:
            return None
        self.feet = Feet(found.first[: n + 1], found.point[:k], found.share[:k])
        listed = found.listed[:n].copy()  # stored for the next step; the other arrays are used in this step only
        apart = self._apart and rests_on_flat_side(self.one, listed)
        new = found.new[:n] if self.start is not None else None
        points = found.depth[:n], found.normal[:n], found.area[:n], found.relative[:n]
        return Overlap(self.one, listed, *points, self.share, apart, new)

    def _measure(self, one: Described, other: Described) -> int:
        """Compute the depths of the points of `one` that are near the surface `other`, and their feet (projections on
        `other`); return the number of these points."""
        candidates, width = self._following.candidates, self.one.half_width + self.other.half_width
        arrays = one.place, one.normal, other.place, other.normal, other.size, other.reach
        if self._about is None or any(new is not old for new, old in zip(arrays, self._arrays, strict=True)):
            asking, points = Asking(*arrays[:2]), Points(*arrays[2:])
            self._about, self._arrays = Bundle(Neighbourhood(asking, points, self._meeting)), arrays
        about = self._about
        proximity.find_beside(len(candidates.asks) // CHUNK + 1, about, candidates, width + self._near, self._found)
        # own normals only for bodies that do not deform: other normals tilt by 1 % and more as the surface crosses cells,
        # which would slow down sliding
        how = width, width + self._near, self._from_feet, self._from_feet and self.one.is_hard
        values = self._counts, self.one.weights(), self.one.velocity, self.other.velocity, self.images
        return int(proximity.measure_depths(about, candidates, self._found, *values, *how))

    def _find_within_planes(self, corners: np.ndarray) -> Overlap | None:
        """Return the overlap with a convex rigid body bounded by planes; None if no point overlaps.

        corners: indices of the points of the other surface that span its planes.
        """
        one, other = self.one, self.other
        normal, level = other.planes()
        places, deepest = other.place[corners], self._meeting.deepest
        middle, place = places.mean(axis=0), one.place
        for axis, _, period in self._seams:
            place = place.copy()
            place[:, axis] -= period * np.round((place[:, axis] - middle[axis]) / period)
        near = ((place > places.min(axis=0) - deepest) & (place < places.max(axis=0) + deepest)).all(axis=1)
        at = np.flatnonzero(near & (self._counts * one.weights() > 0.0))
        height = np.einsum("ij,kj->ik", place[at], normal) - level
        facing = -np.einsum("ij,kj->ik", one.normals()[at], normal)
        on_edge = at >= self._n_faces
        # a surface inclined to a flat side touches it only at an edge; for a round side the limits are wider
        askew, full = (ASKEW, FACING) if one.faces is not None else (NO_CONTACT, FULL_CONTACT)
        # planes with the same direction as the point normal do not touch it; near the rim it may lie beyond them
        meets = facing > NO_CONTACT
        above = np.where(meets, height, -np.inf)
        nearest = above.argmax(axis=1)
        rows = np.arange(len(at))
        depth = one.half_width - above[rows, nearest]
        beyond = np.where(meets, -np.inf, height).max(axis=1) - np.where(on_edge, RIM * other.reach[0], 0.0)
        counts = np.where(on_edge, 1.0, np.clip((facing[rows, nearest] - askew) / (full - askew), 0.0, 1.0))
        within = (depth > 0.0) & (depth < deepest) & (beyond <= 0.0) & (counts > 0.0)
        at, depth, counts, normal = at[within], depth[within], counts[within], normal[nearest[within]]
        if not len(at):
            return None
        # weights of the corners at each position: forces with these weights have the same sum and torque
        arm = places - middle
        spread = np.linalg.pinv(np.einsum("ci,cj->ij", arm, arm), rcond=1e-9, hermitian=True)
        from_middle = place[at] - middle
        self._shares = 1.0 / len(places) + np.einsum("ni,ij,cj->nc", from_middle, spread, arm)
        relative = one.velocity[at] - np.einsum("nc,cd->nd", self._shares, other.velocity[corners])
        area = counts * self._counts[at] * one.weights()[at]
        return Overlap(one, at, depth, normal, area, relative, self.share, self._apart and rests_on_flat_side(one, at))

    def apply(self, overlap: Overlap, force: np.ndarray, forces: Mapping[int, np.ndarray]) -> None:
        super().apply(overlap, force, forces)
        if self._corners is not None:
            forces[id(self.other)][self._corners] -= np.einsum("nc,nd->cd", self._shares, force)
