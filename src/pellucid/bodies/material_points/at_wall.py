"""Contact of a fluid with a plane wall through the material points next to it; the fluid has no surface.

Each point represents a cube whose side touches the wall. At the initial density the cube has the edge e, extends e/2 beyond
the point, and has the side area e². The forces act at the points, where the nodes have mass. In the outermost cell the
pressure of the fluid is therefore too low, by half the pressure of its outermost points. Forces at the sides of the cubes
would give the right pressure at rest, but they would do work on a change of shape that the cubes do not have, and add
energy to moving water.
"""

from collections.abc import Callable

import numpy as np

from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.wall_plane import WallPlane
from pellucid.grid.vectors import scatter_listed
from pellucid.jit import kernel

LAYER = 2.0
"""Mass on which the contact spring of a wall acts, in layers of points, but at most one layer of cells: points at the wall may
move alone. The spring oscillates at the frequency of the fluid: at the highest frequency that the step can resolve, oscillating
points at the wall would sustain waves."""


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

    body: the fluid; plane: the wall; density, speed_of_sound: initial values of the fluid [kg/m³], [m/s]; load: function that
    returns the nodal forces of the grid, shape (nodes, 3), to which the forces on the points are added.
    """

    follows_steps = False

    def __init__(
        self, body: PointsOnGrid, plane: WallPlane, density: float, speed_of_sound: float, load: Callable[[], np.ndarray]
    ) -> None:
        self._body, self._plane, self._load, self._density = body, plane, load, density
        cell, edges = body.grid.lattice.cell, self._edges(body.points.mass[: body.n_there])
        self.mass_per_area = density * min(cell, LAYER * float(np.median(edges)))
        self.rate = speed_of_sound / cell
        self._most = 0.5 * float(edges.max())
        self._listed = np.zeros(body.n_points, np.int64)
        self.begin()

    def _edges(self, mass: np.ndarray) -> np.ndarray:
        """Return the edge lengths [m], shape (n,), of the cubes that points with masses [kg], shape (n,), fill at the initial
        density; in plane problems, of the squares.
        """
        thin = sum(self._body.grid.thin)
        return np.asarray((mass / (self._density * self._body.grid.slice_thickness**thin)) ** (1.0 / (3 - thin)))

    def begin(self) -> None:
        points, plane, grid = self._body.points, self._plane, self._body.grid
        count = _list_beside(points.position, self._body.n_there, plane.normal, plane.level, self._most, self._listed)
        self._at = at = self._listed[:count]
        mass, thin = points.mass[at], sum(grid.thin)
        self.place, self.velocity = points.position[at], points.velocity[at]
        edge = self._edges(mass)
        self.reach = self.half_width = 0.5 * edge
        self.area = -(edge ** (2 - thin) * grid.slice_thickness**thin)[:, None] * plane.normal
        self.slip, self.drag = np.zeros((count, 3)), mass * self.rate

    def add_forces(self, force: np.ndarray) -> None:
        pushed = np.flatnonzero(force.any(axis=1))
        scatter_listed(self._body.mapped, self._body.points.position, self._at[pushed], force[pushed], self._load())
