"""Contact between two triangulated surfaces, and of one surface with itself.

The points of each surface search for triangles of the other. Each surface has a share of the stiffness that grows with its
resolution. In self-contact the surface searches once, with half of the stiffness: each of two layers finds the other one.

A point with overlap d is pushed out by the force k d. The opposite force acts on the corners of the triangle, distributed
with the barycentric coordinates of the closest point. Both forces derive from ½ Σ k d²
(`pellucid.contact.triangles.closest_point`). The normal forces are implicit in the step (`pellucid.contact.implicit`) and
include points that would overlap within the next steps. An impact therefore stops at the contact distance for any speed,
and at rest the surfaces hardly overlap. All contacts of a pair form one system, together with the motion of the vertices
under nodal forces. Friction is a spring along the surface with a damper, limited by the coefficient of friction times the
normal force; each contact of a point with a triangle (slot) stores its own slip.
"""

from collections.abc import Mapping, Sequence
from math import inf

import numpy as np
from scipy import sparse

from pellucid.contact.boxes import Boxes
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.images import Described, Plane, Seam
from pellucid.contact.implicit import solve_forces
from pellucid.contact.overlap import Implicit, Overlap, OverlapLaw, StartOverlap
from pellucid.contact.touch import Touch
from pellucid.contact.triangles.mesh import FORGETS, MARGIN, SEARCHED, TriangleMesh, find_images
from pellucid.contact.triangles.slots import APART, CHUNK, ENTERS, Sight, find_power, make_slots, update_slots

NO_BOXES = Boxes(np.zeros(3), 1.0, (1, 1, 1), np.zeros(2, np.int64), np.zeros(0, np.int64))
OUTSIDE = 1e-6  # largest depth behind faces that a search finds, in edges: surfaces may start in contact
SEPARATE = 1e-6  # smallest initial distance of layers that defines their sides, in thicknesses
AHEAD = 2.0  # number of steps for which an overlap is predicted
VIBRATES = 0.02  # largest gap that counts as a vibration, not as separation, relative to the initial overlap
SHARP = 135.0  # largest fold between neighbouring triangles [degrees] at which points still keep layers apart
OF_SHEETS = 0.5  # share of the springs and dampers along the surface that are stable for one layer on each side of a sheet


class TriangleSide(ContactSurface):
    """Points of one surface that search for triangles of another or of the same surface; each slot of a point stores one
    contact with a triangle.

    one, other: triangle meshes of the points and of the triangles. sides: contact surfaces with these meshes. share: fraction
    of the contact stiffness.
    """

    def __init__(
        self, one: TriangleMesh, other: TriangleMesh, sides: tuple[ContactSurface, ContactSurface], share: float
    ) -> None:
        self.one, self.other, self.share = one, other, share
        thickness = float(np.max(sides[0].half_width) + np.max(sides[1].half_width))
        self.points = one.points_of_itself(thickness) if one is other else one.points
        self._margin = MARGIN * max(one.edge, other.edge)
        ends = thickness, thickness + self._margin, thickness + FORGETS * self._margin
        two_sided = sides[0].two_sided, sides[1].two_sided
        self.sight = Sight(*ends, two_sided[1], not any(two_sided), OUTSIDE * other.edge)
        self.slots = make_slots(len(self.points.place), 2 if sides[0].two_sided else 1)
        self.slip = self.slots.slip.reshape(-1, 3)
        self.start = None if one is other else StartOverlap(other.edge)
        self.state = np.array([0.0, -1.0])
        """Upper bound of the distance by which the surfaces have approached [m], and its value at the last search (-1
        before the first)."""

    def follow(self, last: float) -> float:
        """Increase the upper bound of the distance by which the surfaces have approached by their motion in the previous step;
        return the power of the forces of that step at the current velocities [W].

        last: length of the previous step [s]. Both meshes must have been updated from their bodies before.
        """
        self._nearing = self.one.fastest + self.other.fastest + self.other.speed_against(self.one.mean_velocity)
        self.state[0] += last * self._nearing
        return float(find_power(self.points, self.other.facets, self.slots))

    def find(self, step: float) -> Overlap | None:
        """Return the overlap of the points with triangles, including points that will touch a triangle within a few steps.

        step: step size [s]. Returns None if there are no such points.
        """
        way, searched = self.state.tolist()
        coming = AHEAD * step * self._nearing
        self.sight = self.sight._replace(far=self.sight.thickness + max(self._margin, coming))
        looks = searched < 0.0 or way + coming - searched > SEARCHED * self._margin
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
            return None
        if self.start is not None and searched < 0.0:  # one depth for all points instead of one for each slot
            self._update_slots(boxes, way, 0.0, 0.0, looks)
            self.start.reduce(self.slots.born.ravel())
            self.slots.born.fill(0.0)
            looks = False
        self._update_slots(boxes, way, coming, AHEAD * step, looks)
        if self.start is not None and self.start.depth > 0.0:
            self._open(self.start, way)
        return self._overlap()

    def _overlap(self) -> Overlap | None:
        slots = self.slots
        self._at = p, k = np.nonzero(slots.state != APART)
        if not len(p):
            return None
        facets, corners = self.other.facets, self.other.facets.triangle[slots.triangle[p, k]]
        relative = self.points.velocity[p] - np.einsum("nc,ncd->nd", slots.share[p, k], facets.velocity[corners])
        new = slots.state[p, k] == ENTERS
        slots.lossy[p[new], k[new]] = 0.0
        listed, area = p * slots.state.shape[1] + k, self.points.area[p]
        return Overlap(self, listed, slots.depth[p, k], slots.normal[p, k], area, relative, self.share)

    def _update_slots(self, boxes: Boxes, way: float, coming: float, ahead: float, looks: bool) -> None:
        sight = self.sight
        if self.start is not None and self.start.depth > 0.0:
            sight = sight._replace(thickness=sight.thickness - self.start.depth)
            coming = inf  # measure all gaps, also wide ones: they show when the surfaces separate
        meeting = self.points, self.other.facets, self.slots, boxes, sight
        update_slots((len(self.points.place) - 1) // CHUNK + 1, *meeting, way, coming, ahead, looks)

    def _open(self, start: StartOverlap, way: float) -> None:
        """Reduce the initial overlap by the distance by which the surfaces have separated; way: largest distance by which
        the surfaces may have approached by now [m]."""
        before, filled = start.depth, (self.slots.triangle >= 0) & (self.slots.side != 0)
        apart = self.slots.clear[filled] - way  # gaps minus the distance at which contact acts now
        start.reduce(before - np.where(apart > VIBRATES * before, apart, np.minimum(apart, 0.0)))
        self.slots.clear[...] -= before - start.depth

    def shares(self, mesh: TriangleMesh) -> tuple[np.ndarray, np.ndarray]:
        """Return, for each overlapping point, the c vertices of a mesh that affect its relative velocity, shape (n, c), and
        their weights per axis, shape (n, c, 3).

        The weighted vertex velocities are the contribution of the mesh to the velocity relative to the closest point.
        """
        p, k = self._at
        found = []
        if mesh is self.one:
            found.append((self.points.corner[p], np.repeat(self.points.share[p][:, :, None], 3, axis=2)))
        if mesh is self.other:
            image, vertex = np.divmod(mesh.facets.triangle[self.slots.triangle[p, k]], mesh.n_vertices)
            found.append((vertex, -self.slots.share[p, k][:, :, None] * mesh.flips[image]))
        vertices, shares = zip(*found, strict=True)
        return np.concatenate(vertices, axis=1), np.concatenate(shares, axis=1)

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        return {**self.slots._asdict(), "way": self.state}

    def given_normal(self) -> np.ndarray:
        """Return the normal forces of the previous step on the overlapping points [N], shape (n,)."""
        lossy, normal = self.slots.lossy[self._at], self.slots.normal[self._at]
        return np.maximum(-np.einsum("ij,ij->i", lossy, normal), 0.0)

    def keep(self, given: np.ndarray) -> None:
        """Store friction minus normal force of this step on the overlapping points [N], shape (n, 3), for `follow`, which
        computes their power in the next step."""
        self.slots.lossy[self._at] = given

    def add_forces(self, force: np.ndarray) -> None:
        """Distribute forces on the overlapping points [N], shape (n, 3), to the vertices of both surfaces."""
        for mesh in {id(mesh): mesh for mesh in (self.one, self.other)}.values():
            vertices, shares = self.shares(mesh)
            total = np.zeros((mesh.n_vertices, 3))
            np.add.at(total, vertices, shares * force[:, None])
            mesh.add_forces(total)


class TrianglePair(Touch):
    """Contact of two triangulated surfaces, or of one surface with itself.

    Parameters
    ----------
    one, other
        Surfaces in contact; the same surface twice for self-contact.
    friction
        Coefficient of friction μ.
    courant, step
        Step size as a fraction of the largest stable step, and fixed step of the case [s] or 0.
    name
        Name of the force on the first of two surfaces for probes.
    planes, seams
        Planes of symmetry and seams of a periodic grid.
    """

    is_last = True

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
        super().__init__((one,) if one is other else (one, other), OverlapLaw((one, other), friction, courant, step=step), name)
        self.law.is_implicit = True
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
            share *= OF_SHEETS if any(surface.is_sheet for surface in surfaces) else 1.0
            self.sides.append(TriangleSide(self._meshes[i], self._meshes[j], surfaces, share))
        if one is other:
            one.of_itself = self.sides[0].state_arrays()

    @property
    def distance(self) -> float:
        return super().distance if len(self.surfaces) == 2 else 2.0 * super().distance

    def warning(self) -> str | None:
        if len(self.surfaces) == 2 or not self.surfaces[0].is_sheet:
            return None
        angle, place = self._meshes[0].find_sharpest_fold()
        if angle < SHARP:
            return None
        at = ", ".join(f"{x:.4g}" for x in place)
        return (
            f"body {self.surfaces[0].body} is folded by {angle:.0f} degrees between two neighbouring elements near "
            f"({at}) m, more than {SHARP:g}: the elements are too coarse for this fold, and layers can pass through each "
            f"other there. Use elements with edges well below {self._meshes[0].edge:.3g} m, a larger `bending.rigidity`, "
            "or a larger `thickness`."
        )

    def start_overlaps(self) -> list[StartOverlap]:
        return [side.start for side in self.sides if side.start is not None]

    def start_depth(self) -> float:
        """Return the initial overlap of the surfaces [m]; for self-contact, the largest initial overlap of a point with a
        triangle."""
        return super().start_depth() if len(self.surfaces) == 2 else max(float(side.slots.born.max()) for side in self.sides)

    def follow(self, last: float) -> None:
        for mesh in self._meshes:
            mesh.follow()
        self.before = sum(side.follow(last) for side in self.sides)

    def place_without_side(self) -> np.ndarray | None:
        """Return an initial position at which layers of a surface coincide, so that the side on which they touch is undefined
        [m], shape (3,); None if there is no such position.

        Fills the slots, i.e. finds the triangles that each point may touch.
        """
        self.follow(0.0)
        self.find({})
        for side in self.sides:
            most = side.sight.thickness * (1.0 - SEPARATE)
            at = np.flatnonzero((side.slots.born >= most).any(axis=1) & (most > 0.0))
            if len(at):
                return np.asarray(side.points.place[at[0]])
        return None

    def find(self, described: dict[int, Described]) -> bool:
        self.impulse, self.law.lent = np.zeros(3), 0.0
        found = [(side, side.find(self.step)) for side in self.sides]
        self._touching = [(side, overlap) for side, overlap in found if overlap is not None]
        return len(self._touching) > 0

    def push(self, dt: float, last: float, forces: dict[int, np.ndarray], touched: dict[int, np.ndarray]) -> None:
        overlaps = [overlap for _, overlap in self._touching]
        slipping = {id(side): np.zeros(len(side.slip), bool) for side in self.sides}
        found = self.law.forces(overlaps, dt, last, slipping, self.before, self._solve(dt))
        for (side, _), force, given in zip(self._touching, found, self.law.given, strict=True):
            side.keep(given)
            side.add_forces(force)
            if len(self.surfaces) == 2:
                self.impulse += (1.0 if side is self.sides[0] else -1.0) * dt * force.sum(axis=0)

    def _solve(self, dt: float) -> list[Implicit]:
        """Return the implicit normal forces of all overlaps in a step dt [s], solved as one system."""
        sides = [side for side, _ in self._touching]
        normal = np.concatenate([overlap.normal for _, overlap in self._touching])
        ahead = np.concatenate([overlap.depth for _, overlap in self._touching])
        factors = []
        for mesh in self._meshes:
            vertices, shares = (np.concatenate(parts) for parts in zip(*(side.shares(mesh) for side in sides), strict=True))
            free, factor = mesh.response(3 * vertices[:, :, None] + np.arange(3), shares * normal[:, None], dt)
            ahead -= dt * free
            factors.append(factor)
        stiffness = [self.law.normal_stiffness(overlap) for _, overlap in self._touching]
        factor = factors[0] if len(factors) == 1 else sparse.csr_array(sparse.hstack(factors))
        return solve_forces(factor, ahead, stiffness, [side.given_normal() for side in sides], self.law.is_steady)

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        """Return the arrays of a checkpoint: the slots (contacts of points with triangles) of both sides, and the bounds of the
        approach of the surfaces.

        For self-contact the result is empty: these arrays are stored with the body.
        """
        if len(self.surfaces) == 1:
            return {}
        return {f"{i}/{name}": array for i, side in enumerate(self.sides) for name, array in side.state_arrays().items()}
