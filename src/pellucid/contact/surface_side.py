"""Detection of the overlap of the points of one surface with another surface."""

from collections.abc import Mapping, Sequence

import numpy as np

from pellucid.contact import proximity
from pellucid.contact.contact_side import ContactSide
from pellucid.contact.contact_surface import FULL_CONTACT, NO_CONTACT, ContactSurface
from pellucid.contact.dead_stop import ASKEW, FACING
from pellucid.contact.following import Following
from pellucid.contact.images import Described, Feet, Seam
from pellucid.contact.overlap import Overlap, StartOverlap, rests_on_flat_side, stop_apart
from pellucid.contact.proximity import CHUNK, Asking, Meeting, Neighbourhood, Points
from pellucid.jit.bundle import Bundle

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
