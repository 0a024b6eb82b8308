"""Contact between surfaces: forces of their overlap, friction, and damping of what vibrates as fast as a cell.

Each point of either surface that lies in the other is pushed out by the pressure κ d of its depth d. The forces of such a
pressure are those of an energy, ½ Σ κ a d²: what glides or rolls gets back behind the place of contact what it gave ahead of
it, where an impulse that stops an approach gives nothing back. 1/κ is the sum of both sides' compliance, that of a layer of
the surface which swings at the fastest rate that the step of its body allows, so that contact bounds no step.

Friction is a spring along the surface that slides where its force would be more than μ times the pressure (Coulomb); a contact
that sticks has no limit. Both surfaces are asked, each with a share of the stiffness that grows with how fine it is: the points
of a coarse surface are a bed of nails for a fine one.

A damper in parallel takes a tenth of what is critical for the masses of the two layers: it ends their vibrations within some
of their periods, and hardly acts on bodies as a whole. Bodies of which none deforms hardly rebound, and their overlap hardens
under what presses them: see `pellucid.contact.dead_stop` and `pellucid.contact.overlap`.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pellucid.contact import proximity
from pellucid.contact.contact_energy import ContactEnergy
from pellucid.contact.contact_surface import FULL, NONE, ContactSurface
from pellucid.contact.dead_stop import ASKEW, FACING, SETTLED
from pellucid.contact.feet import Feet
from pellucid.contact.following import Following
from pellucid.contact.images import Described, Plane, Seam, describe
from pellucid.contact.implicit import Block, NormalForces
from pellucid.contact.overlap import (
    GivenBefore,
    Implicit,
    Overlap,
    OverlapLaw,
    StartOverlap,
    may_press,
    mean_way,
    rests_on_flat_side,
    stop_apart,
)
from pellucid.contact.proximity import CHUNK, GAP, NORMAL, SHARE, Asking, Meeting, Neighbourhood, Points
from pellucid.contact.steady_contact import ContactLead
from pellucid.contact.touch import Touch
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.state import of_owner, with_owner

RIM = 0.01  # of the reach of points: how far beyond the rim of a plane an edge may lie that rests on it
ROUNDS = 3  # at most, in which forces of several contacts of flat sides on one body are found
NOWHERE = np.zeros(0, np.int64)
SLACK = 0.1  # of the reach of points of the other surface: a depth that is none in a steady state
NEAR = 0.1  # of the reach of points of a surface that deforms: how far above it a place may lie beneath their mean place


class HalfPair:
    """The points of one surface against the other, with this share of the stiffness.

    by_edges: whether edges count, as they do where neither body deforms; they bear with all of the stiffness. seams: of a
    periodic grid. ahead: whether points count that come in within the step, or were in touch in the step before. After `find`,
    `overlap` has the points that overlap, and `feet` their feet on the other surface.
    """

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
        self.one, self.other, self._meeting, self.share = one, other, meeting, share
        self.overlap: Overlap | None = None
        self.given, self.pushed = GivenBefore(), NOWHERE
        self.feet = Feet(np.zeros(1, np.int64), NOWHERE, np.zeros(0))
        self.images: Described | None = None
        self._seams = seams
        self._n_faces = len(one.place) - one.n_edge_points
        self._counts = np.ones(len(one.place))
        self._counts[self._n_faces :] = 1.0 / share if by_edges else 0.0
        self._apart = by_edges and stop_apart(one, other)
        self._corners = None
        if by_edges and other.faces is not None and not one.two_sided:
            self._corners = np.unique(other.faces[other.faces >= 0])
        self._following = Following(other, float(np.max(one.half_width + other.half_width)))
        # over a body that deforms a sheet follows the third-order distance: feet lie deeper by a part of its thickness
        self._from_feet = not (other.is_hard or one.is_sheet)
        self._ahead, near = ahead, NEAR * float(np.median(other.reach))
        self._near = near if self._from_feet or ahead else 0.0
        self.start = None if one.is_hard and other.is_hard else StartOverlap(float(other.reach.max()))
        self.lead: ContactLead | None = None
        """In steady states, of the half whose overlap is removed."""
        self.lent = 0.0
        """Energy over the stiffness that the overlap got as leads changed in this step [m³]."""
        self._make_room()

    def begin_steady(self) -> None:
        """Ask for the other surface alone, with leads."""
        self.lead, self.share, self._ahead = ContactLead(self.one), 1.0, False
        self._near = float(np.median(self.one.reach))  # of points across a gap, which counts in the mean overlap
        # where overlaps vanish, points that press lie now on this, now on that side of the plane of the nearest point
        self._meeting = self._meeting._replace(slack=SLACK * float(np.median(self.other.reach)))

    def _make_room(self) -> None:
        self._found = Bundle(proximity.make_room(len(self._following.candidates.asks), self._following.most_near))

    def find(self, one: Described, other: Described, step: float = 0.0) -> bool:
        """Find the points of the one surface that overlap with the other; whether there are any. step: length of the
        step, or of the one before if that was longer [s]."""
        if self._corners is not None:
            return self._find_within_planes(self._corners)
        self.overlap, self.images, self.lent, before = None, other, 0.0, self._following.candidates
        may = self._following.find(len(self.one.place), one, other, (self.one.stands, self.other.stands))
        if self._following.candidates is not before:
            self._make_room()
        depth, listed, normal, rows = np.zeros(0), NOWHERE, np.zeros((0, 3)), NOWHERE
        if may:
            depth, listed, normal, rows = self._find_depths(one, other)
        if self.start is not None:
            depth = self.start.reduce(depth)
        if self.lead is not None:
            area = self._found.beside[rows, SHARE] * self._counts[listed] * self.one.weights()[listed]
            depth, self.lent = self.lead.applied(listed, depth, area)
        kept, relative = depth > 0.0, np.zeros((0, 3))
        if self._ahead and len(depth):
            relative = one.velocity[listed] - self.feet.gather(other.velocity)
            kept = may_press(depth, relative, normal, step) | np.isin(listed, self.pushed)
        if not kept.any():
            return False
        if not kept.all():
            depth, listed, normal, rows, self.feet = depth[kept], listed[kept], normal[kept], rows[kept], self.feet.only(kept)
        area = self._found.beside[rows, SHARE] * self._counts[listed] * self.one.weights()[listed]
        relative = relative[kept] if self._ahead else one.velocity[listed] - self.feet.gather(other.velocity)
        apart = self._apart and rests_on_flat_side(self.one, listed)
        new = ~np.isin(listed, self.pushed) if self.start is not None else None
        self.overlap = Overlap(self.one, listed, depth, normal, area, relative, self.share, apart, new)
        return True

    def _find_depths(self, one: Described, other: Described) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Find depths [m] of points, which points, normals of the other surface, and their rows; and their feet."""
        candidates, widths = self._following.candidates, self.one.half_width + self.other.half_width
        points = Points(other.place, other.normal, other.size, other.reach)
        about, found = Neighbourhood(Asking(one.place, one.normal), points, candidates, self._meeting), self._found
        proximity.find_beside(len(candidates.asks) // CHUNK + 1, about, widths + self._near, found)
        n, k = proximity.find_feet(about, found, self._counts, widths + self._near)
        rows = found.candidate[:n]
        self.feet = Feet(found.first[: n + 1], found.point[:k], found.share[:k])
        listed, normal = candidates.asks[rows], found.beside[rows, NORMAL : NORMAL + 3]
        if not self._from_feet:
            return widths - found.beside[rows, GAP], listed, normal, rows
        # from the feet, which the forces move: with another distance a surface that bends and swings wins energy
        if self.one.is_hard:
            # areas of a surface that deforms lean as cells are crossed, by a hundredth and more, and brake what slides
            own = one.normal[listed]
            normal = np.where(np.einsum("ij,ij->i", own, normal)[:, None] > 0.0, own, -own)
        away = np.einsum("ij,ij->i", normal, one.place[listed] - found.place[:n])
        return widths - away, listed, normal, rows

    def _find_within_planes(self, corners: np.ndarray) -> bool:
        """Find the same against planes through corners, at places with the velocity of the other body, which is rigid."""
        one, other = self.one, self.other
        self.overlap = None
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
        # what lies askew to a flat side touches it at an edge; a round side does not, over as far as the other sinks in
        askew, full = (ASKEW, FACING) if one.faces is not None else (NONE, FULL)
        # planes that look the same way as the point do not touch it: beside the rim it may lie a little beyond them
        meets = facing > NONE
        above = np.where(meets, height, -np.inf)
        nearest = above.argmax(axis=1)
        rows = np.arange(len(at))
        depth = one.half_width - above[rows, nearest]
        beyond = np.where(meets, -np.inf, height).max(axis=1) - np.where(on_edge, RIM * other.reach[0], 0.0)
        counts = np.where(on_edge, 1.0, np.clip((facing[rows, nearest] - askew) / (full - askew), 0.0, 1.0))
        within = (depth > 0.0) & (depth < deepest) & (beyond <= 0.0) & (counts > 0.0)
        at, depth, counts, normal = at[within], depth[within], counts[within], normal[nearest[within]]
        if not len(at):
            return False
        # shares of the corners with which these make up each place: their sums of forces and torques are those at the place
        arm = places - middle
        spread = np.linalg.pinv(np.einsum("ci,cj->ij", arm, arm), rcond=1e-9, hermitian=True)
        from_middle = place[at] - middle
        self._shares = 1.0 / len(places) + np.einsum("ni,ij,cj->nc", from_middle, spread, arm)
        relative = one.velocity[at] - np.einsum("nc,cd->nd", self._shares, other.velocity[corners])
        area = counts * self._counts[at] * one.weights()[at]
        self.overlap = Overlap(one, at, depth, normal, area, relative, self.share, self._apart and rests_on_flat_side(one, at))
        return True

    def pressed_before(self, overlap: Overlap) -> np.ndarray:
        """Return the implicit normal forces of the points of the overlap in the step before [N], shape (n,)."""
        return self.given.pressed(overlap)

    def apply(self, at: np.ndarray, force: np.ndarray, forces: tuple[np.ndarray, np.ndarray]) -> None:
        """Forces on listed points [N], shape (n, 3), and against the other surface, into those of both."""
        forces[0][at] += force
        if self._corners is not None:
            forces[1][self._corners] -= np.einsum("nc,nd->cd", self._shares, force)
            return
        self.feet.spread(-force, forces[1])


class SurfacePair(Touch):
    """Two surfaces that touch. Each asks the other with its points; a sheet asks alone: of two halves one may not overlap, and
    half of its damper does not stop its nodes.

    friction, courant, swing, cell, step: see `OverlapLaw`. dimension: of the surfaces, 2, in the plane 1, along a line 0;
    thickness: of a slice [m]. seams: of a periodic grid.
    """

    law: OverlapLaw

    def __init__(
        self,
        surfaces: tuple[ContactSurface, ContactSurface],
        friction: float,
        dimension: int,
        thickness: float,
        courant: float,
        swing: float = 0.0,
        name: str | None = None,
        cell: float = np.inf,
        seams: Sequence[Seam] = (),
        step: float = 0.0,
    ) -> None:
        super().__init__(surfaces, OverlapLaw(surfaces, friction, courant, swing, cell, step), name)
        self._described = dict[int, Described]()
        one, other = surfaces
        asking = [(one, other), (other, one)]
        if one.is_sheet != other.is_sheet:
            asking = [(first, second) for first, second in asking if first.is_sheet]
        fine = [1.0 / float(np.median(first.reach)) ** 2 for first, _ in asking]
        self._halves = []
        for (first, second), share in zip(asking, fine, strict=True):
            meeting = Meeting((first.two_sided, second.two_sided), _deepest(second), dimension, thickness, first.is_sheet)
            how = share / sum(fine), self.law.stop is not None, seams, self.law.is_implicit
            self._halves.append(HalfPair(first, second, meeting, *how))

    def find(self, described: dict[int, Described]) -> bool:
        """Find where they overlap; whether they do. described: the points of surfaces, by identity."""
        self._described = described
        self.impulse, self.before, self.law.lent = np.zeros(3), 0.0, 0.0
        found = False
        for half in self._halves:
            self.before += half.given.power(half.one.velocity, half.other.velocity)
            half.pushed = half.given.forget()
            found |= half.find(described[id(half.one)], described[id(half.other)], self.step)
            self.law.lent += half.share * self.law.stiffness * half.lent
        return found

    def given_before(self) -> list[GivenBefore]:
        return [half.given for half in self._halves]

    @property
    def sight(self) -> float:
        """Distance at which the surfaces notice each other [m]."""
        return min(float(half.other.reach.min()) for half in self._halves)

    def start_overlaps(self) -> list[StartOverlap]:
        return [half.start for half in self._halves if half.start is not None]

    def begin_steady(self) -> None:
        """Let the finer of the surfaces that deform search alone, with leads.

        With the leads of both there would be more than one for each overlap, and where no overlap is left, points of the other
        one would touch now and then, by the curvature of the surfaces.
        """
        super().begin_steady()
        self.law.is_implicit = False  # leads remove the overlap
        soft = [half for half in self._halves if not half.one.is_hard]
        for half in sorted(soft, key=lambda half: -half.share)[:1]:
            half.begin_steady()
            self._halves = [half]

    def leads(self) -> list[ContactLead]:
        return [half.lead for half in self._halves if half.lead is not None]

    def way(self) -> np.ndarray:
        """The unit vector along which the overlap found pushes in the mean, (3,), either way."""
        return mean_way(self.overlaps(), self.surfaces[0])

    def overlaps(self) -> list[Overlap]:
        """Those of both halves."""
        return [half.overlap for half in self._halves if half.overlap is not None]

    def push(self, dt: float, last: float, forces: dict[int, np.ndarray], touched: dict[int, np.ndarray]) -> None:
        """Add the forces of the overlap over a step dt [s] to those of the surfaces; last: length of the step before."""
        touching = [(half, half.overlap) for half in self._halves if half.overlap is not None]
        implicit: list[Implicit] = []
        if self.law.is_implicit:
            k = self.law.normal_stiffness
            blocks = [
                Block(overlap, k(overlap), half.pressed_before(overlap), half.other, half.images, half.feet)
                for half, overlap in touching
            ]
            implicit = NormalForces(blocks, dt, self._described, forces).solve()
        found = self.law.forces([overlap for _, overlap in touching], dt, last, touched, self.before, implicit)
        if self.law.counts_both_ends:
            for (half, overlap), given in zip(touching, self.law.given, strict=True):
                half.given.keep(overlap.listed, given, half.feet, half.images)
        for (half, overlap), force in zip(touching, found, strict=True):
            half.apply(overlap.listed, force, (forces[id(half.one)], forces[id(half.other)]))
            self.impulse += (1.0 if half.one is self.surfaces[0] else -1.0) * dt * force.sum(axis=0)


def _deepest(surface: ContactSurface) -> float:
    """How deep a place may lie behind a point of a surface that still counts [m]: less than half through a body."""
    extent = np.ptp(surface.place, axis=0)
    thick = extent[extent > 1e-3 * extent.max()].min(initial=np.inf)
    reach = float(np.median(surface.reach))
    return reach if surface.two_sided else min(reach, 0.4 * float(thick))


class SurfacePairs:
    """All surfaces of a simulation that touch each other or walls."""

    def __init__(self, pairs: Sequence[Touch], planes: Sequence[Plane] = (), seams: Sequence[Seam] = ()) -> None:
        """planes: of symmetry; seams: of a periodic grid."""
        self._pairs, self._planes, self._seams = pairs, planes, seams
        self.surfaces = list({id(surface): surface for pair in pairs for surface in pair.surfaces}.values())
        self.energy = ContactEnergy()
        self._described: dict[int, Described] = {}  # as they were, for those that stand
        self._forces: dict[int, np.ndarray] = {}
        self._holding = {id(surface) for surface in self.surfaces}  # those of which friction may hold points
        self._untouched: dict[int, tuple[ContactSurface, np.ndarray]] = {}
        self._is_steady = False

    def __len__(self) -> int:
        return len(self._pairs)

    def act(self, dt: float, last: float, time: float, passing: float) -> None:
        """Give the bodies the forces of contact over a step dt [s]; last: length of the step before [s].

        time: at which it begins [s]; passing: by how much the time of the loads grows [s].
        """
        for pair in self._pairs:
            pair.begin(time, passing / dt if dt > 0.0 else 0.0)
        described, forces, touched = self._described, dict[int, np.ndarray](), dict[int, np.ndarray]()
        for surface in self.surfaces:
            surface.begin()
            if not surface.stands or id(surface) not in described:
                described[id(surface)] = describe(surface, self._planes, self._seams)
            touched[id(surface)] = np.zeros(len(surface.place), bool)
            surface.swings, surface.pushed_along, surface.pushed = 0.0, [], np.zeros(6)
        for pair in self._pairs:
            pair.step = max(dt, last)
            pair.follow(last)
        touching = [pair.find(described) for pair in self._pairs]
        for pair, touches in zip(self._pairs, touching, strict=True):
            rigid = [surface for surface in pair.surfaces if touches and surface.rigid_mass < np.inf]
            if rigid:
                way = pair.way()
                for surface in rigid:
                    surface.pushed_along.append(way)
        self._settle([pair for pair, touches in zip(self._pairs, touching, strict=True) if touches], dt, last)
        for pair, touches in zip(self._pairs, touching, strict=True):
            if not touches:
                pair.law.separate(last, pair.before)
                continue
            for surface in pair.surfaces:
                if id(surface) not in forces:
                    forces[id(surface)] = self._cleared(surface, len(described[id(surface)].place))
            pair.push(dt, last, forces, touched)
        self.energy.begin_step(pair.law.held for pair in self._pairs)
        for surface in self.surfaces:
            holds = bool(touched[id(surface)].any())
            if self._is_steady:
                self._untouched[id(surface)] = surface, ~touched[id(surface)]
            elif holds or id(surface) in self._holding:
                _let_go(surface.slip, touched[id(surface)])
                (self._holding.add if holds else self._holding.discard)(id(surface))
            if id(surface) in forces:
                surface.add_forces(described[id(surface)].fold(forces[id(surface)]))

    def _cleared(self, surface: ContactSurface, n: int) -> np.ndarray:
        """Return an array of n forces, which are zero, kept from step to step."""
        kept = self._forces.get(id(surface))
        if kept is None or len(kept) != n:
            kept = self._forces[id(surface)] = np.zeros((n, 3))
        else:
            kept.fill(0.0)
        return kept

    def _settle(self, touching: Sequence[Touch], dt: float, last: float) -> None:
        """Find the forces of flat sides in rounds where bodies are in several such contacts, as in a stack."""
        apart = [pair for pair in touching if pair.stops_apart]
        for pair in apart:
            if pair.law.stop is not None:
                pair.law.stop.begin()
        several = False
        for surface in self.surfaces:
            count = sum(surface in pair.surfaces for pair in apart)
            surface.stops_at_once = count == len(surface.pushed_along)
            several |= surface.rigid_mass < np.inf and count > 1 and surface.stops_at_once
        for _ in range(ROUNDS if several else 0):
            before = [surface.pushed.copy() for surface in self.surfaces]
            for pair in apart:
                pair.law.settle(pair.overlaps(), dt, last)
            change = max(float(np.abs(s.pushed - old).max()) for s, old in zip(self.surfaces, before, strict=True))
            if change <= SETTLED * max(float(np.abs(surface.pushed).max()) for surface in self.surfaces):
                break

    # steady states

    def begin_steady(self) -> None:
        """Find equilibria from now on: remove overlaps, and let friction and overlaps of the start change with equilibria."""
        self._is_steady = True
        for pair in self._pairs:
            pair.begin_steady()

    def renew_leads(self) -> None:
        """Renew the leads of contact as the coming step begins, see `pellucid.contact.steady_contact`."""
        for lead in self._leads():
            lead.is_due = True

    @property
    def lent(self) -> float:
        """Energy that contact got in this step as leads changed [J]."""
        return sum(pair.law.lent for pair in self._pairs)

    def lead_change(self) -> tuple[float, float]:
        """Return the largest change when leads were renewed last, and the largest lead [m]."""
        leads = self._leads()
        return max((lead.change for lead in leads), default=0.0), max((lead.largest for lead in leads), default=0.0)

    def reach_equilibrium(self) -> None:
        """Begin with friction and overlaps of the start from the equilibrium that was found."""
        for pair in self._pairs:
            pair.reach_equilibrium()
        for surface, at in self._untouched.values():
            surface.slip[at] = 0.0

    def _leads(self) -> list[ContactLead]:
        return [lead for pair in self._pairs for lead in pair.leads()]

    def touching(self) -> Iterator[tuple[ContactSurface, np.ndarray]]:
        """Yield surfaces and the places of their points that overlap with others [m], shape (n, 3)."""
        for pair in self._pairs:
            for overlap in pair.overlaps():
                yield overlap.one, overlap.one.place[overlap.listed]

    def against_sheets(self) -> Iterator[tuple[ContactSurface, ContactSurface, float]]:
        """Yield each sheet, another surface that is none and that it touches, and the length of the step [s]."""
        for pair in self._pairs:
            if len(pair.surfaces) == 2 and pair.surfaces[0].is_sheet != pair.surfaces[1].is_sheet:
                one, other = pair.surfaces
                yield (one, other, pair.step) if one.is_sheet else (other, one, pair.step)

    def find_start_overlaps(self) -> list[tuple[Touch, float]]:
        """Find what overlaps as the run begins: pairs with the depth that exerts no pressure [m]."""
        starting = [pair for pair in self._pairs if not all(surface.is_hard for surface in pair.surfaces)]
        described = dict[int, Described]()
        for surface in {id(surface): surface for pair in starting for surface in pair.surfaces}.values():
            surface.begin()
            described[id(surface)] = describe(surface, self._planes, self._seams)
        for pair in starting:
            pair.begin(0.0, 0.0)
            pair.follow(0.0)
            pair.find(described)
        return [(pair, depth) for pair in starting if (depth := pair.start_depth()) > 0.0]

    def skip_start_overlaps(self, names: Collection[str]) -> None:
        """Let bodies with these names touch each other, and walls, from the start on: they did so in an earlier run."""
        for pair in self._pairs:
            if all(surface.body in names for surface in pair.surfaces):
                for start in pair.start_overlaps():
                    start.skip()

    def impulses(self) -> dict[str, np.ndarray]:
        """On the first body of each pair with a name over this step [N s], (3,)."""
        total: dict[str, np.ndarray] = {}
        for pair in self._pairs:
            if pair.name is not None:
                total[pair.name] = total.get(pair.name, np.zeros(3)) + pair.impulse
        return total

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays of a checkpoint: which sides of each other surfaces of triangles touch."""
        arrays: dict[str, np.ndarray] = {}
        for i, pair in enumerate(self._pairs):
            arrays |= with_owner(str(i), pair.state_arrays())
        return arrays

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Go on from the arrays of a checkpoint."""
        for i, pair in enumerate(self._pairs):
            pair.restore_arrays(of_owner(str(i), arrays))

    def state_numbers(self) -> dict[str, object]:
        """What a checkpoint keeps."""
        stops = [pair.law.stop.state_numbers() for pair in self._pairs if pair.law.stop]
        starts = [start.state_numbers() for start in self._start_overlaps()]
        given = [given.state_numbers() for given in self._given_before()]
        leads = [lead.state_numbers() for lead in self._leads()]
        lost = [pair.law.lost for pair in self._pairs]
        energy = self.energy.state_numbers()
        numbers: dict[str, object] = {"energy": energy, "stops": stops, "starts": starts, "given": given, "lost": lost}
        if self._is_steady:
            numbers["leads"] = leads
        return numbers

    def _given_before(self) -> list[GivenBefore]:
        return [given for pair in self._pairs for given in pair.given_before()]

    def _start_overlaps(self) -> list[StartOverlap]:
        return [start for pair in self._pairs for start in pair.start_overlaps()]

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Go on from a checkpoint."""
        self.energy.restore(numbers["energy"])
        stops = [pair.law.stop for pair in self._pairs if pair.law.stop]
        for stop, kept in zip(stops, numbers["stops"], strict=True):
            stop.restore(kept)
        for start, kept in zip(self._start_overlaps(), numbers["starts"], strict=True):
            start.restore(kept)
        for given, kept in zip(self._given_before(), numbers["given"], strict=True):
            given.restore(kept)
        for lead, kept in zip(self._leads(), numbers.get("leads", ()), strict=True):
            lead.restore(kept)
        for pair, lost in zip(self._pairs, numbers["lost"], strict=True):
            pair.law.lost = lost

    def external_work(self) -> float:
        """What walls that move did over this step [J]."""
        return sum(pair.external_work() for pair in self._pairs)


@kernel()
def _let_go(slip, touched):
    """Forget how far points were carried that friction does not hold, shape (m, 3) and (m,)."""
    for p in range(len(slip)):
        if not touched[p]:
            slip[p, 0] = slip[p, 1] = slip[p, 2] = 0.0
