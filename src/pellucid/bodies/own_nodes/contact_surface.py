"""The surfaces of bodies with their own nodes, by which others touch them: points within the triangles between these.

A triangle is divided into n² equal ones, as small as asked, and has a point in the middle of each. Points follow its corners
and hand forces on to these by their shares in it, so that they lie on the surface and others do not pass between the nodes.
"""

from collections.abc import Callable

import numpy as np
from scipy import sparse

from pellucid.contact.contact_surface import ContactSurface
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.grid.lattice import Grid

SPACINGS = 2.5  # between points, over which the weights of one reach
LONGEST = 1.0  # cells: longest edge of the equal triangles


class PointsOfFaces(ContactSurface):
    """Points of triangles between the corners, n of them.

    triangles: corners, shape (t, 3); places, velocities: give those of the corners [m], [m/s], shape (n, 3); take: gives the
    body forces on the corners [N], shape (n, 3). hard: whether all nodes follow prescribed motions.
    """

    def __init__(
        self,
        grid: Grid,
        triangles: np.ndarray,
        places: Callable[[], np.ndarray],
        velocities: Callable[[], np.ndarray],
        take: Callable[[np.ndarray], None],
        hard: bool,
    ) -> None:
        self._triangles, self._places, self._velocities, self._take = triangles, places, velocities, take
        self._thin, lattice = np.array(grid.thin), grid.lattice
        self._middle = np.array(lattice.lower) + 0.5 * grid.slice_thickness
        self.is_hard = hard
        corners = np.where(self._thin, 0.0, places())[triangles]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        parts = np.maximum(1, np.ceil(edges / (LONGEST * lattice.cell) - 1e-9)).astype(np.int64)
        owner, shares = _middles(parts)
        self._owner, self._part = owner, 1.0 / parts[owner][:, None] ** 2
        m = len(owner)
        columns, rows = triangles[owner].ravel(), np.repeat(np.arange(m), 3)
        self._shares = sparse.csr_array((shares.ravel(), (rows, columns)), shape=(m, len(places())))
        self._to_corners = sparse.csr_array(self._shares.T)
        self.reach = SPACINGS * (edges / parts)[owner]
        self.place, self.velocity, self.area, self.slip = (np.zeros((m, 3)) for _ in range(4))
        self.begin()

    def begin(self) -> None:
        """Follow the corners; across thin axes nothing varies."""
        places = self._places()
        self.place[...], self.velocity[...] = self._shares @ places, self._shares @ self._velocities()
        self.area[...] = self._part * vector_areas(places, self._triangles)[self._owner]
        self.place[:, self._thin] = self._middle[self._thin]
        self.area[:, self._thin] = 0.0

    def add_forces(self, force: np.ndarray) -> None:
        """To the corners."""
        self._take(self._to_corners @ force)

    def per_area(self, amount: np.ndarray) -> float:
        """What the corners have, shape (n,), over the area that they share: the median of those that have any."""
        area = self._to_corners @ self.sizes()
        return float(np.median(amount[area > 0.0] / area[area > 0.0]))


def _middles(parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The points of triangles that are divided along each edge into so many parts: in which triangle each lies, and its shares
    of the corners, shape (m, 3)."""
    owners, shares = [], []
    for n in np.unique(parts):
        here = np.flatnonzero(parts == n)
        upright = [(i + 1 / 3, j + 1 / 3) for i in range(n) for j in range(n - i)]
        turned = [(i + 2 / 3, j + 2 / 3) for i in range(n - 1) for j in range(n - 1 - i)]
        within = np.array(upright + turned) / n
        weights = np.column_stack([within, 1.0 - within.sum(axis=1)])
        owners.append(np.repeat(here, len(weights)))
        shares.append(np.tile(weights, (len(here), 1)))
    return np.concatenate(owners), np.concatenate(shares)
