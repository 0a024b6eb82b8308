"""Points of a fluid beside a plane, by which walls touch it: it has no surface.

Each point stands for a cube of its volume, and the pressure of the wall acts on the side of that, at the foot of the point on
the plane. The nodes about the point take it there by their functions and slopes at the point, N_I + r·∇N_I with r from the
point to its foot: at the point itself, half of it would be missing in the pressure of the outermost layer.
"""

from collections.abc import Callable

import numpy as np
from numpy import uintp

from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.wall import Plane
from pellucid.grid.stencil import node_at, stencil
from pellucid.jit import kernel


@kernel()
def _list_beside(position, n, normal, level, most, listed):
    """Which of the first n points are no higher than `most` above a plane, into `listed`; how many."""
    count = 0
    for p in range(n):
        height = position[p, 0] * normal[0] + position[p, 1] * normal[1] + position[p, 2] * normal[2] - level
        if height < most:
            listed[count] = p
            count += 1
    return count


@kernel()
def _scatter_at_feet(mapped, listed, force, foot, target):
    """Add forces, shape (n, 3), of listed points to the nodes, at `foot` from each point [m], shape (n, 3)."""
    lattice, h = mapped.lattice, mapped.lattice.inverse_cell
    for e in range(len(listed)):
        about = stencil(mapped.functions, lattice, mapped.points.position, uintp(listed[e]))
        wx, wy, wz, gx, gy, gz = about.wx, about.wy, about.wz, about.gx, about.gy, about.gz
        rx, ry, rz = h * foot[e, 0], h * foot[e, 1], h * foot[e, 2]
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    I = node_at(about, lattice, a, b, c)
                    w = wx[a] * wy[b] * (wz[c] + rz * gz[c]) + (rx * gx[a] * wy[b] + ry * wx[a] * gy[b]) * wz[c]
                    for d in range(3):
                        target[I, d] += w * force[e, d]


class PointsAtWall(ContactSurface):
    """The points of a fluid within a cell above a plane, as they are in each step.

    density [kg/m³] and speed of sound [m/s]: of the fluid at the start; load: forces on the nodes, shape (nodes, 3), to which
    those on the points are added.
    """

    def __init__(
        self, body: PointsOnGrid, plane: Plane, density: float, speed_of_sound: float, load: Callable[[], np.ndarray]
    ) -> None:
        self._body, self._plane, self._load = body, plane, load
        self.mass_per_area, self.rate = density * body.grid.lattice.cell, speed_of_sound / body.grid.lattice.cell
        self._listed = np.zeros(body.n_points, np.int64)
        self.begin()

    def begin(self) -> None:
        """Find the points beside the plane."""
        points, plane, cell = self._body.points, self._plane, self._body.grid.lattice.cell
        count = _list_beside(points.position, self._body.n_there, plane.normal, plane.level, cell, self._listed)
        self._at = at = self._listed[:count]
        self.place, self.velocity = points.position[at], points.velocity[at]
        n_thin = sum(self._body.grid.thin)
        across = self._body.grid.slice_thickness**n_thin
        edge = (points.volume[at] / across) ** (1.0 / (3 - n_thin))
        self.half_width = np.minimum(0.5 * edge, cell)
        # of the side of the cube along the plane
        self.area = -(edge ** (2 - n_thin) * across)[:, None] * plane.normal
        self.reach, self.slip = self.half_width, np.zeros((count, 3))
        self.drag = points.mass[at] * self.rate

    def add_forces(self, force: np.ndarray) -> None:
        """To the nodes about the points, at their feet on the plane."""
        listed = np.flatnonzero(force.any(axis=1))
        foot = -self._plane.height(self.place[listed])[:, None] * self._plane.normal
        _scatter_at_feet(self._body.mapped, self._at[listed], force[listed], foot, self._load())
