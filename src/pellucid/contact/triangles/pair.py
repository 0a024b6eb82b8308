"""Contact between two surfaces of triangles, and of one surface with itself.

Both surfaces search with their points for the triangles of the other, each with a share of the stiffness that grows with how
fine it is. A surface that touches itself searches once, with half of the stiffness: each of two layers searches for the other.
"""

from collections.abc import Mapping, Sequence
from math import inf

import numpy as np

from pellucid.contact.boxes import Boxes
from pellucid.contact.contact_energy import Held
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.dead_stop import DeadStop
from pellucid.contact.images import Described, Plane, Seam
from pellucid.contact.overlap import Overlap, StartOverlap
from pellucid.contact.touch import Touch
from pellucid.contact.triangles.forces import (
    AHEAD,
    N_SUMS,
    PENDING,
    ROUNDS,
    STORED,
    Law,
    add_areas,
    add_impulses,
    find_forces,
    find_taken,
    make_law,
)
from pellucid.contact.triangles.mesh import FORGETS, MARGIN, SEARCHED, TriangleMesh, find_images
from pellucid.contact.triangles.slots import APART, CHUNK, Sight, find_feet, make_slots

NO_BOXES = Boxes(np.zeros(3), 1.0, (1, 1, 1), np.zeros(2, np.int64), np.zeros(0, np.int64))
OUTSIDE = 1e-6  # of an edge: how far behind its faces a solid still finds a point, as surfaces may start in contact
TINY = 1e-300  # m
SEPARATE = 1e-6  # of the thickness: least distance of layers at the start that tells their sides


class SlotEnergy:
    """Energy of a pair, in the terms of other contact laws."""

    stop: DeadStop | None = None

    is_steady, lent = False, 0.0

    def __init__(self) -> None:
        self.held, self.taken, self.lost = Held(), 0.0, 0.0

    def separate(self, last: float, before: float = 0.0) -> None:
        """Nothing overlaps any more."""
        self.held = Held(taken=self.taken)

    def settle(self, overlaps: Sequence[Overlap], dt: float, last: float) -> None:
        """Do nothing: no rigid body is stopped."""

    def reach_equilibrium(self) -> None:
        """Do nothing: slots keep what friction holds."""


class AskingSide:
    """The points of one surface that look for triangles of another one, or of the same."""

    def __init__(self, one: TriangleMesh, other: TriangleMesh, sides: tuple[ContactSurface, ContactSurface], law: Law) -> None:
        self.one, self.other, self.law = one, other, law
        thickness = float(np.max(sides[0].half_width) + np.max(sides[1].half_width))
        self.points = one.points_of_itself(thickness) if one is other else one.points
        margin = MARGIN * max(one.edge, other.edge)
        ends = thickness, thickness + margin, thickness + FORGETS * margin
        two_sided = sides[0].two_sided, sides[1].two_sided
        self.sight = Sight(*ends, two_sided[1], not any(two_sided), OUTSIDE * other.edge)
        self.slots = make_slots(len(self.points.place), 2 if sides[0].two_sided else 1)
        self.start = None if one is other else StartOverlap(other.edge)
        self.state = np.array([0.0, -1.0])
        """Length of the way by which the surfaces may have come nearer [m], and the same at the last search, -1 before one."""

    def follow(self, last: float) -> float:
        """Return the energy that dampers and friction took in the step before, of a length `last` [s]; both meshes have
        followed their bodies."""
        self._last = last
        self._coming = last * (self.one.fastest + self.other.fastest + self.other.speed_against(self.one.mean_velocity))
        self.state[0] += self._coming
        return float(find_taken(self.points, self.other.facets, self.slots, last))

    def find(self) -> bool:
        """Find where the points overlap with triangles; return whether any does."""
        way, searched = self.state.tolist()
        looks = searched < 0.0 or way - searched > SEARCHED * (self.sight.far - self.sight.thickness)
        boxes = NO_BOXES
        if looks:
            self.state[1] = way
            place, far, of_other = self.points.place, self.sight.far, self.other.facets.place
            lower = np.maximum(place.min(axis=0), of_other.min(axis=0) - far)
            upper = np.minimum(place.max(axis=0), of_other.max(axis=0) + far)
            if looks := bool((lower <= upper).all()):
                boxes = self.other.boxes(far, lower, upper)
        if not looks and not (self.slots.triangle >= 0).any():
            if self.start is not None:
                self.start.reduce(np.zeros(0))
            return False
        if self.start is not None and searched < 0.0:  # one depth for all points instead of one for each slot
            self._find_feet(boxes, way, (0.0, 0.0), looks)
            self.start.reduce(self.slots.born.ravel())
            self.slots.born.fill(0.0)
            looks = False
        foreseen = (AHEAD * self._coming, AHEAD * self._last) if self.law.stops > 0.0 else (0.0, 0.0)
        self._find_feet(boxes, way, foreseen, looks)
        if self.start is not None and self.start.depth > 0.0:
            self._open(self.start, way)
        return bool((self.slots.state != APART).any())

    def _find_feet(self, boxes: Boxes, way: float, foreseen: tuple[float, float], looks: bool) -> None:
        sight, (coming, ahead) = self.sight, foreseen
        if self.start is not None and self.start.depth > 0.0:
            sight = sight._replace(thickness=sight.thickness - self.start.depth)
            coming = inf  # so that all gaps are measured: they show when the surfaces come apart
        meeting = self.points, self.other.facets, self.slots, boxes, sight
        find_feet((len(self.points.place) - 1) // CHUNK + 1, *meeting, way, coming, ahead, looks)

    def _open(self, start: StartOverlap, way: float) -> None:
        """Reduce the overlap of the start as far as the surfaces have come apart."""
        before, filled = start.depth, (self.slots.triangle >= 0) & (self.slots.side != 0)
        apart = self.slots.clear[filled] - way  # gaps beyond the distance at which contact acts now
        start.reduce(before - apart)
        self.slots.clear[...] -= before - start.depth

    def add_areas(self) -> None:
        """Add the areas of the points that touch to those on the vertices of both surfaces."""
        add_areas(self.points, self.other.facets, self.slots, self.one.touched_area, self.other.touched_area)
        self.impulse = np.zeros(self.slots.triangle.shape)

    def add_impulses(self, dt: float) -> None:
        """Add a round of the dampers of sheets over a step dt [s]."""
        one, other = self.one, self.other
        masses = one.mass_by_touched_area(), other.mass_by_touched_area()
        meeting = self.points, other.facets, self.slots, self.law
        changes, given = (one.change, other.change), (one.given, other.given)
        add_impulses(*meeting, dt, *masses, other.flips, changes, self.impulse, given)

    def push(self, dt: float, last: float) -> tuple[np.ndarray, np.ndarray]:
        """Add the forces over a step dt [s] to the vertices of both surfaces; last: length of the step before [s].

        Returns the sums of `pellucid.contact.triangles.forces` and the force on the points [N], (3,).
        """
        sums = np.zeros(N_SUMS)
        of_points, of_facets = np.zeros((self.one.n_vertices, 3)), np.zeros_like(self.other.facets.place)
        masses = self.one.mass_by_touched_area(), self.other.mass_by_touched_area()
        meeting = self.points, self.other.facets, self.slots, self.law
        find_forces(*meeting, dt, last, *masses, self.impulse, of_points, of_facets, sums)
        if self.one is self.other:
            self.one.add_forces(of_points + self.one.fold(of_facets))
        else:
            self.one.add_forces(of_points)
            self.other.add_forces(self.other.fold(of_facets))
        return sums, of_points.sum(axis=0)


class TrianglePair(Touch):
    """Two surfaces of triangles that touch, or one that touches itself.

    Parameters
    ----------
    one, other
        The surfaces; the same one twice for contact with itself.
    friction
        Coefficient μ.
    courant, step
        Fraction of the largest stable step that the case takes, and its fixed step [s], or 0.
    name
        Name for probes of the force on the first of two surfaces.
    planes, seams
        Planes of symmetry and seams of a periodic grid.
    """

    def __init__(
        self,
        one: ContactSurface,
        other: ContactSurface,
        friction: float,
        courant: float,
        step: float = 0.0,
        name: str | None = None,
        planes: Sequence[Plane] = (),
        seams: Sequence[Seam] = (),
    ) -> None:
        self._energy = SlotEnergy()
        super().__init__((one,) if one is other else (one, other), self._energy, name)
        images = find_images(planes, seams)
        self._meshes = [TriangleMesh(surface, images) for surface in self.surfaces]
        if one is other:
            order = [(0, 0, 0.5)]
        else:
            fine = [1.0 / mesh.edge for mesh in self._meshes]
            order = [(0, 1, fine[0] / sum(fine)), (1, 0, fine[1] / sum(fine))]
        self.sides = []
        for i, j, share in order:
            surfaces = self.surfaces[i], self.surfaces[j]
            law = make_law(surfaces, share, friction, courant, step)
            self.sides.append(AskingSide(self._meshes[i], self._meshes[j], surfaces, law))

    @property
    def distance(self) -> float:
        return super().distance if len(self.surfaces) == 2 else 2.0 * super().distance

    def start_overlaps(self) -> list[StartOverlap]:
        return [side.start for side in self.sides if side.start is not None]

    def start_depth(self) -> float:
        """Return the depth of the start [m]; of a surface that touches itself, the largest one of its slots."""
        return super().start_depth() if len(self.surfaces) == 2 else max(float(side.slots.born.max()) for side in self.sides)

    def follow(self, last: float) -> None:
        for mesh in self._meshes:
            mesh.follow()
        self._energy.taken = sum(side.follow(last) for side in self.sides)

    def begin_steady(self) -> None:
        super().begin_steady()
        for side in self.sides:
            side.law = side.law._replace(is_steady=True)

    def reach_equilibrium(self) -> None:
        for side in self.sides:
            slots = side.slots
            length = np.linalg.norm(slots.slip, axis=2)
            longest = side.law.friction * np.maximum(slots.depth, 0.0)  # the limit over the stiffness
            slots.slip[...] *= np.where(length > longest, longest / np.maximum(length, TINY), 1.0)[:, :, None]

    def place_without_side(self) -> np.ndarray | None:
        """Return a place at the start where layers lie on each other [m], (3,), so that none is on a side of the other; None if
        there is no such place. It fills the slots."""
        self.follow(0.0)
        self.find({})
        for side in self.sides:
            most = side.sight.thickness * (1.0 - SEPARATE)
            at = np.flatnonzero((side.slots.born >= most).any(axis=1) & (most > 0.0))
            if len(at):
                return np.asarray(side.points.place[at[0]])
        return None

    def find(self, described: dict[int, Described]) -> bool:
        self.impulse = np.zeros(3)
        touches = [side.find() for side in self.sides]
        return any(touches)

    def way(self) -> np.ndarray:
        """Return zeros: no rigid body is pushed."""
        return np.zeros(3)

    def overlaps(self) -> list[Overlap]:
        """Return none: slots are not lists of points."""
        return []

    def push(self, dt: float, last: float, forces: dict[int, np.ndarray], touched: dict[int, np.ndarray]) -> None:
        stored = pending = 0.0
        for mesh in self._meshes:
            mesh.begin_rounds()
        for side in self.sides:
            side.add_areas()
        for _ in range(ROUNDS if self.sides[0].law.stops > 0.0 else 0):
            for side in self.sides:
                side.add_impulses(dt)
            for mesh in self._meshes:
                mesh.end_round()
        for i, side in enumerate(self.sides):
            sums, force = side.push(dt, last)
            stored, pending = stored + sums[STORED], pending + sums[PENDING]
            if len(self.surfaces) == 2:
                self.impulse += (1.0 if i == 0 else -1.0) * dt * force
        self._energy.held = Held(stored, self._energy.taken, pending)

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        """Return what a checkpoint stores: sides, slots, and the ways of the surfaces."""
        return {
            f"{i}/{name}": array
            for i, side in enumerate(self.sides)
            for name, array in {**side.slots._asdict(), "way": side.state}.items()
        }
