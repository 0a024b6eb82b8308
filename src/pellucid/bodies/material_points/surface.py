"""The contact surface of a solid of material points: contact points sampled from its shape when a run is set up, and the search
for parts of the surface that approach each other during a run."""

from collections.abc import Callable, Mapping
from typing import Protocol, runtime_checkable

import numpy as np
from scipy.spatial import cKDTree

from pellucid.bodies.material_points.grid_surface import GridSurface
from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.contact.approaching_parts import (
    APPROACHED,
    ASIDE,
    FEWEST,
    NARROW,
    OPPOSITE,
    Gap,
    find_near,
    measure_gaps,
    select_facing,
)
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase
from pellucid.jit.bundle import Bundle

ABOUT = 12  # number of points used to fit a deformation gradient
MOVES = 0.5
"""Fraction of a layer of cells that moves with the surface at once: forces on the surface act on the nodes on both sides of
it, and half of the cells of these nodes lies inside the body (0.40 to 0.50 for GIMP functions)."""
DAMPING = 0.15
"""Damping ratio of contact of bodies that deform. Contact springs swing faster than the waves that the grid carries, so that
their vibration stays at the surface. With 0.1 the force of colliding bars vanishes several times after they meet; larger
ratios take more of the energy of coarse bodies that collide."""
STIFFEST = 10.0
"""Largest stiffness of contact springs [ρc²/h]. They then yield like a tenth of a cell, less than the error of the grid in
the compliance of the body; stiffer springs would only amplify noise in the positions of the surface points."""


class RigidState(Protocol):
    """Centre of mass and mobility of a rigid body at the start of a step.

    Attributes: centre: centre of mass [m]; per_mass: change of velocity per unit impulse along each axis [1/kg], shape (3,);
    per_inertia: change of angular velocity per unit angular impulse [1/(kg m²)], shape (3, 3).
    """

    @property
    def centre(self) -> np.ndarray: ...
    @property
    def per_mass(self) -> np.ndarray: ...
    @property
    def per_inertia(self) -> np.ndarray: ...

    def mobility_along(self, place: np.ndarray, force: np.ndarray) -> float:
        """Return Σ f·a [N²/kg] for forces f [N] on the body at positions `place` [m], shape (m, 3) each, and the
        accelerations a of the body at these positions due to the forces; see `ContactSurface.mobility_along`."""

    def turning(self, place: np.ndarray) -> np.ndarray:
        """Return the velocities [m/s] due to the rotation of the body at positions `place` [m], shape (m, 3) both."""


@runtime_checkable
class TakesForces(Protocol):
    """A constraint that moves a rigid body and accepts forces on the body."""

    def moves_freely(self) -> bool:
        """Return True if the body has at least one free degree of freedom."""

    def state(self) -> RigidState:
        """Return centre of mass and mobility of the rigid body at the start of a step."""

    def add_forces(self, place: np.ndarray, force: np.ndarray) -> None:
        """Add forces [N] that act on the rigid body at positions `place` [m], shape (m, 3) each, in the coming step."""


class RigidSurface(GridSurface):
    """The contact surface of a rigid body, which rotates with the body; forces on the contact points act on the body as a
    whole.
    """

    takes: TakesForces
    _found: RigidState | None = None

    @property
    def _state(self) -> RigidState:
        """Centre of mass and mobility of the rigid body at the start of the step; computed at the first use, since most
        contacts with bodies do not need them.
        """
        if self._found is None:
            self._found = self.takes.state()
        return self._found

    def follow(self, dt: float) -> None:
        """Do nothing: the constraint that moves the body also moves its surface."""

    def begin(self) -> None:
        super().begin()
        self._found = None

    def mobility_along(self, place: np.ndarray, force: np.ndarray) -> float:
        return self._state.mobility_along(place, force)

    def mobility_rows(self, place: np.ndarray, force: np.ndarray) -> np.ndarray:
        sizes, axes = np.linalg.eigh(self._state.per_inertia)
        about = np.cross(place - self._state.centre, force)
        turned = np.einsum("ni,ij->nj", about, axes * np.sqrt(np.maximum(sizes, 0.0)))
        return np.concatenate([np.sqrt(self._state.per_mass) * force, turned], axis=1)

    def turning(self, place: np.ndarray) -> np.ndarray:
        return self._state.turning(place)

    def add_forces(self, force: np.ndarray) -> None:
        listed = self.list_pushed(force)
        self.takes.add_forces(self.place[listed], force[listed])


def surface_of(
    model: SeededBody,
    grid_case: GridCase,
    grid: Grid,
    arrays: Mapping[str, np.ndarray],
    mapped: Bundle,
    load: Callable[[], np.ndarray],
    rigid: bool,
    hard: bool,
    first: np.ndarray | None = None,
) -> GridSurface | None:
    """Build the contact surface of a body from its shape within the grid; None if the shape has no surface in the grid.

    arrays, mapped: arrays of the material points and their data for kernels; load: function that returns the nodal forces,
    shape (nodes, 3), to which surface forces are added; rigid: True if forces act on the body as a whole; hard: True if the
    body does not deform; first: initial positions of the points in an earlier run, by number [m], shape (n, 3).
    """
    place, area = model.boundary(grid_case, hard)
    if not len(place):
        return None
    spacing, edges = model.boundary_spacing(grid_case, hard), None
    if hard:
        side = float(max(np.maximum(sign * area, 0.0).sum(axis=0).max() for sign in (1.0, -1.0)))
        edges = model.edge_points(grid_case, side)
        place, area = np.concatenate([place, edges.place]), np.concatenate([area, np.zeros_like(edges.place)])
    numbers = arrays["id"]
    begun = arrays["position"] if first is None else first[numbers]
    tree = cKDTree(begun)
    nearest = np.asarray(tree.query(place)[1])
    if first is None and not model.has_users_fields:
        velocity = model.initial_velocity(place)
    else:
        velocity = arrays["velocity"][nearest]
    if first is not None:
        n = 0 if edges is None else len(edges.place)
        ways = area if edges is None else np.concatenate([area[: len(area) - n], edges.normal])
        place, ways = carried(place, ways, nearest, tree, arrays["position"])
        area = np.where(np.arange(len(area))[:, None] < len(area) - n, ways, 0.0)
        if edges is not None:
            edges = edges._replace(normal=ways[len(area) - n :])
    kind = RigidSurface if rigid else GridSurface
    surface = kind(arrays, mapped, numbers[nearest], place, area, spacing, load, velocity, edges)
    surface.is_hard = hard
    layer, surface.rate = model.material.density * grid_case.cell, model.wave_speeds()[0] / grid_case.cell
    surface.mass_per_area, stiffness = layer, layer * surface.rate**2
    surface.stiffness_range = stiffness, stiffness
    if not hard:
        surface.mass_per_area, surface.damping = MOVES * layer, DAMPING
        surface.stiffness_range = stiffness, STIFFEST * stiffness
    return surface


def carried(
    place: np.ndarray, area: np.ndarray, nearest: np.ndarray, tree: cKDTree, position: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions [m] and vector areas [m²], shape (m, 3) each, to which the material has carried points of a
    surface.

    place, area: initial positions [m] and vector areas [m²], shape (m, 3). Each point follows the material point `nearest` to
    it, shape (m,), with the deformation gradient fitted to that point's neighbours. tree: initial positions of the material
    points; position: present positions [m], shape (n, 3).
    """
    begun = tree.data
    _, about = tree.query(begun[nearest], k=min(ABOUT, len(begun)))
    about = about.reshape(len(nearest), -1)
    before, after = begun[about] - begun[nearest][:, None], position[about] - position[nearest][:, None]
    spread = np.einsum("mki,mkj->mij", before, before)
    # along directions without neighbours nothing is known: there it goes on as it is
    values, vectors = np.linalg.eigh(spread)
    known = values > 1e-6 * values[:, -1:]
    inverse = np.where(known, 1.0 / np.where(known, values, 1.0), 0.0)
    unknown = np.einsum("mia,ma,mja->mij", vectors, (~known).astype(float), vectors)
    fitted = np.einsum("mki,mkj->mij", after, before) @ np.einsum("mia,ma,mja->mij", vectors, inverse, vectors)
    gradient = fitted + unknown
    cofactor = np.linalg.det(gradient)[:, None, None] * np.linalg.inv(gradient).swapaxes(1, 2)
    carried_place = position[nearest] + np.einsum("mij,mj->mi", gradient, place - begun[nearest])
    return carried_place, np.einsum("mij,mj->mi", cofactor, area)


DEFORMED = 0.1  # deformation of the surface between searches, in cells
NEARER = 0.1  # approach of two points, in cells, before their normals are computed
FOLDED = 4.0  # smallest initial distance of parts that can fold onto each other, in cells
SHEARED = 0.5  # largest deviation of points from the rigid motion of their hosts, in cells


class SurfaceParts:
    """Points on the surface of a body, about one per grid cell, that move with its material points; used to detect closing
    gaps.

    begun: initial positions of all material points by number [m], shape (n, 3).
    """

    def __init__(self, model: SeededBody, grid: GridCase, begun: np.ndarray) -> None:
        self._begun = begun
        self._place, area = model.boundary(grid, hard=False, spacing=grid.cell)
        self._area, self._normal, self._cell = area, _unit(area), grid.cell
        self._lower, self._periods = np.array(grid.lower, float), np.array(grid.periods(), float)
        self._tree = cKDTree(self._begun)
        self.hosts = np.asarray(self._tree.query(self._place)[1], np.int64).reshape(-1)
        """Numbers of the material points with which the surface points move, shape (m,)."""
        self._host = self._begun[self.hosts]  # places of these, without jumps over seams [m]
        self._searched = self._host.copy()

    def has_deformed(self, host: np.ndarray) -> bool:
        """Return True if the surface has deformed since the last search for gaps. host: present positions of the material
        points `hosts`, which move the surface points [m], shape (m, 3).
        """
        self._host = self._host + _shortest(host - self._host, self._periods)
        if not len(host):
            return False
        away = _after_rigid_motion(self._searched, self._host)[0] - self._host
        return float(np.einsum("ij,ij->i", away, away).max()) > (DEFORMED * self._cell) ** 2

    def find_closing_gap(self, position: np.ndarray, is_filled: Callable[[np.ndarray, float], np.ndarray]) -> Gap | None:
        """Return the narrowest gap between parts of the surface that have approached each other; None if there is none.

        position: positions of all material points [m], shape (n, 3), by number; is_filled: function that returns a mask of the
        positions [m], shape (k, 3), that lie within a distance [m] of other bodies.
        """
        self._searched = self._host.copy()
        if len(position) != len(self._begun):  # points that leave take their surface with them
            return None
        cell = self._cell
        _, turn = _after_rigid_motion(self._begun[self.hosts], self._host)
        near = self._host + (self._place - self._begun[self.hosts]) @ turn
        one, other = find_near(near, float(np.hypot(NARROW, ASIDE) + SHEARED) * cell, self._lower, self._periods)
        before, _, away = measure_gaps(self._place, self._normal, one, other, self._periods)
        distance = np.linalg.norm(away, axis=1)
        faced = np.einsum("ij,ij->i", self._normal[one], self._normal[other]) < OPPOSITE
        now = np.linalg.norm(_shortest(near[other] - near[one], self._periods), axis=1)
        # narrower gaps are reported before a run; both sides of a thin part have a negative one
        across = faced & (before > NARROW * cell)
        before = np.where(across, before, distance)
        possible = (across | (distance > FOLDED * cell)) & (before - now > NEARER * cell)
        one, other, before = one[possible], other[possible], before[possible]
        if len(one) < FEWEST:
            return None
        used, numbers = np.unique(np.concatenate([one, other]), return_inverse=True)
        one, other = numbers[: len(one)], numbers[len(one) :]
        whole = self._begun + (self._host - self._begun[self.hosts]).mean(axis=0)
        whole += _shortest(position - whole, self._periods)
        place, area = carried(self._place[used], self._area[used], self.hosts[used], self._tree, whole)
        facing, kept = select_facing(place, _unit(area), one, other, cell, self._periods)
        before = before[kept]
        closes = before - facing.gap > APPROACHED * cell
        at = np.flatnonzero(closes)
        if len(at) >= FEWEST:
            at = at[~is_filled(facing.middle[at], 0.5 * cell)]
        if len(at) < FEWEST:
            return None
        narrowest = at[np.argmin(facing.gap[at])]
        return Gap(float(facing.gap[narrowest]), float(before[narrowest]), facing.middle[narrowest])


def _shortest(way: np.ndarray, periods: np.ndarray) -> np.ndarray:
    """Return displacements [m], shape (n, 3), reduced by whole periods of the grid [m], shape (3,), to the shortest
    equivalent displacements."""
    folds = periods > 0.0
    shortest = way.copy()
    shortest[:, folds] -= periods[folds] * np.round(way[:, folds] / periods[folds])
    return shortest


def _after_rigid_motion(before: np.ndarray, after: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions `before` [m], shape (n, 3), after the rigid motion for which they are closest to `after`, and
    the transposed rotation matrix of this motion (Kabsch 1976, Acta Cryst. A 32, 922)."""
    first, last = before.mean(axis=0), after.mean(axis=0)
    left, _, right = np.linalg.svd((before - first).T @ (after - last))
    signs = np.array([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    turn = (left * signs) @ right
    return (before - first) @ turn + last, turn


def _unit(area: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(area, axis=1, keepdims=True)
    return np.asarray(area / np.where(size > 0.0, size, 1.0))
