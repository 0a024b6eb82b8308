"""Contact of bodies of material points: solids by their contact surface, fluids with walls by the points next to them.

A fluid has no surface: each of its points represents a cube whose side touches the wall. At the initial density the cube has
the edge e, extends e/2 beyond the point, and has the side area e². The forces act at the points, where the nodes have mass.
In the outermost cell the pressure of the fluid is therefore too low, by half the pressure of its outermost points. Forces at
the sides of the cubes would give the right pressure at rest, but they would do work on a change of shape that the cubes do
not have, and add energy to moving water.
"""

from collections.abc import Callable, Mapping, Sequence

import numpy as np

from pellucid.bodies.material_points.grid_surface import GridSurface, fill
from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.bodies.material_points.surface import RigidSurface, SurfaceParts, TakesForces, surface_of
from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.contact.approaching_parts import describe_gap
from pellucid.contact.contact_body import WarnsOfApproach
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.wall_plane import WallPlane
from pellucid.energy import FIRST_LOAD
from pellucid.grid.model import GridCase
from pellucid.grid.transfer import gather_listed, scatter_listed
from pellucid.jit import kernel
from pellucid.materials.contract import PointMaterial
from pellucid.parts.capabilities import BoundByContact, HasContactSurface, HasPointsAtWalls
from pellucid.ranks.domain import domain

LAYER = 2.0
"""Mass on which the contact spring of a wall acts, in layers of points, but at most one layer of cells: points at the wall may
move alone. The spring oscillates at the frequency of the fluid: at the highest frequency that the step can resolve, oscillating
points at the wall would sustain waves."""


class PointsInContact(PointsOnGrid, HasContactSurface, BoundByContact, HasPointsAtWalls, WarnsOfApproach):
    """Base class of bodies of material points: contact of solids by their surface, and of fluids with walls by their points."""

    material: PointMaterial
    contact_surface: GridSurface | None = None
    _model: SeededBody
    _grid_case: GridCase
    _takes_in: bool
    _begun: np.ndarray | None = None
    """Initial positions by point number [m], shape (n, 3), if this process stores all."""
    _surface_parts: SurfaceParts | None = None
    _begun_surface: Mapping[str, np.ndarray] = {}
    """Arrays of the contact surface in the run that the body continues."""

    @property
    def _strains(self) -> bool:
        """True if the velocity gradients of the grid strain the body, i.e. no constraint moves it as a whole."""
        return self.constraint is None or self.constraint.strains

    def has_surface(self) -> bool:
        return not self.material.flows

    def make_contact_surface(self, column: int) -> GridSurface | None:
        self.storage.keep_whole()
        leads: object = self.constraint
        takes = leads if isinstance(leads, TakesForces) else None
        where = self.grid, self.arrays, self.mapped, self._load_of(column)
        first = self._model.seeded(self._grid_case).position if self._goes_on else None
        self.contact_surface = surface_of(
            self._model, self._grid_case, *where, rigid=takes is not None, hard=not self._strains, first=first
        )
        if self._goes_on and self.contact_surface is not None:
            self.contact_surface.go_on(self._begun_surface)
        if isinstance(self.contact_surface, RigidSurface) and takes is not None:
            self.contact_surface.takes = takes
            if takes.moves_freely():
                self.contact_surface.rigid_mass = self.mass
        return self.contact_surface

    def make_points_at(self, plane: WallPlane, column: int) -> ContactSurface | None:
        if not self.material.flows:
            return None
        self.storage.keep_whole()
        if self.storage.n_present == 0:
            return None
        return PointsAtWall(self, plane, self.material.density, self.material.wave_speeds()[0], self._load_of(column))

    def _load_of(self, column: int) -> Callable[[], np.ndarray]:
        """Return a function that returns the nodal forces of the grid [N], shape (nodes, 3), whose work is recorded in column
        `column` of the works of a step (`StepWork.works`).
        """
        return lambda: self.velocity_field.load_row(column - FIRST_LOAD)

    def _follow_order(self) -> None:
        if self.contact_surface is not None:
            self.contact_surface.find_hosts()

    def move_surface(self, dt: float) -> None:
        if self.contact_surface is not None:
            self.contact_surface.follow(dt)

    def load_state(self, state: Mapping[str, np.ndarray]) -> None:
        super().load_state(state)
        self._begun_surface = {name: array for name, array in state.items() if name.startswith("surface/")}

    def bound_by_contact(self, touching: Sequence[ContactSurface]) -> None:
        if not any(surface is self.contact_surface for surface in touching):
            self.contact_surface = None
        if self.contact_surface is not None:
            self.storage.keep_whole()
            self.totals.rate = max(self.totals.rate, self.contact_surface.least_rate)

    def approach_warning(self, is_filled: Callable[[np.ndarray, float], np.ndarray]) -> str | None:
        if self.material.flows or not self._strains or self._takes_in:
            return None
        if self._surface_parts is None:
            begun = self._model.seeded(self._grid_case).position if self._begun is None else self._begun
            self._surface_parts, self._begun = SurfaceParts(self._model, self._grid_case, begun), None
        parts = self._surface_parts
        if not parts.has_deformed(self._positions_of(parts.hosts)):
            return None
        gap = parts.find_closing_gap(np.asarray(self.field("position")), is_filled)
        return None if gap is None else describe_gap(self.name, gap, self._grid_case.cell, at_start=False)

    def _positions_of(self, numbers: np.ndarray) -> np.ndarray:
        """Return the positions of points by their numbers [m], shape (k, 3)."""
        if domain.is_cut:
            return np.asarray(self.field("position")[numbers])
        stored = np.empty(self.n_points, np.int64)
        stored[self.arrays["id"]] = np.arange(self.n_points)
        return np.asarray(self.arrays["position"][stored[numbers]])


@kernel()
def _list_beside(position, n, normal, level, most, listed):
    """List into `listed` the numbers of the points, among the first n, that lie less than `most` [m] above the plane normal ·
    x = level; return the number of points listed. position: positions of the points [m], shape (points, 3).
    """
    count = 0
    for p in range(n):
        height = position[p, 0] * normal[0] + position[p, 1] * normal[1] + position[p, 2] * normal[2] - level
        if height < most:
            listed[count] = p
            count += 1
    return count


class PointsAtWall(ContactSurface):
    """Contact surface of a fluid at a plane wall: the material points next to the plane, updated in each step.

    The nodes move the points with velocities that differ from those of the points by the smoothing of the transfers. The
    velocity of the surface is that with which a point moved in the last step, so that its product with a force is the change
    of the energy of a spring; a point that comes next to the plane has its own velocity first.

    body: the fluid; plane: the wall; density, speed_of_sound: initial values of the fluid [kg/m³], [m/s]; load: function that
    returns the nodal forces of the grid, shape (nodes, 3), to which the forces on the points are added.
    """

    follows_steps = False

    def __init__(
        self, body: PointsOnGrid, plane: WallPlane, density: float, speed_of_sound: float, load: Callable[[], np.ndarray]
    ) -> None:
        self._body, self._plane, self._load, self._density = body, plane, load, density
        cell, edges = body.grid.lattice.cell, self._edges(body.points.mass[: body.storage.n_present])
        self.mass_per_area = density * min(cell, LAYER * float(np.median(edges)))
        self.rate = speed_of_sound / cell
        self._most = 0.5 * float(edges.max())
        self._listed = np.zeros(body.n_points, np.int64)
        self._moved, self._motion = np.zeros(0, np.int64), np.zeros((0, 3))
        self.begin()

    def _edges(self, mass: np.ndarray) -> np.ndarray:
        """Return the edge lengths [m], shape (n,), of the cubes that points with masses [kg], shape (n,), fill at the initial
        density; in plane problems, of the squares.
        """
        thin = sum(self._body.grid.thin)
        return np.asarray((mass / (self._density * self._body.grid.slice_thickness**thin)) ** (1.0 / (3 - thin)))

    def begin(self) -> None:
        points, plane, grid = self._body.points, self._plane, self._body.grid
        count = _list_beside(points.position, self._body.storage.n_present, plane.normal, plane.level, self._most, self._listed)
        self._at = at = self._listed[:count]
        mass, thin = points.mass[at], sum(grid.thin)
        self.place, self.velocity = points.position[at], points.velocity[at]
        numbers = self._body.arrays["id"][at]
        known = np.isin(numbers, self._moved)
        self.velocity[known] = self._motion[np.searchsorted(self._moved, numbers[known])]
        self._moved = np.zeros(0, np.int64)
        edge = self._edges(mass)
        self.reach = self.half_width = 0.5 * edge
        self.area = -(edge ** (2 - thin) * grid.slice_thickness**thin)[:, None] * plane.normal
        self.slip, self.drag = np.zeros((count, 3)), mass * self.rate

    def add_forces(self, force: np.ndarray) -> None:
        pushed = np.flatnonzero(force.any(axis=1))
        scatter_listed(self._body.mapped, self._body.points.position, self._at[pushed], force[pushed], self._load())

    def power(self, force: np.ndarray, mean: bool) -> float:
        """Return the power [W] of forces on the points [N], shape (m, 3), along the mean velocities of the nodes if `mean` is
        True; else along the velocities with which the nodes move the points, which become those of the surface."""
        nodes = self._body.mapped.nodes
        found = self._interpolate(nodes.mean_velocity if mean else nodes.velocity)
        if not mean:
            numbers = self._body.arrays["id"][self._at]
            order = np.argsort(numbers)
            self._moved, self._motion = numbers[order], found[order]
        return float(np.sum(force * found))

    def _interpolate(self, velocities: np.ndarray) -> np.ndarray:
        """Return the nodal velocities [m/s], shape (nodes, 3), interpolated to the points next to the plane, shape (m, 3)."""
        position, mapped, found = self._body.points.position, self._body.mapped, np.zeros((len(self._at), 3))
        how = mapped, position
        fill(self._at, mapped.slabs, lambda rows, target: gather_listed(*how, self._at[rows], velocities, target), found)
        return found

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        return {"moved": self._moved, "motion": self._motion}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        self._moved, self._motion = arrays["moved"], arrays["motion"]
