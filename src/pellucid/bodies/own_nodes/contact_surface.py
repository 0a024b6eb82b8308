"""Contact surfaces of bodies with their own nodes.

Solids, and membranes with prescribed motion, have points within the triangles between their nodes (`PointsOfFaces`). A
triangle is divided into n² equal ones, as small as needed, with a point at the centroid of each. Points move with the
corners and distribute forces to them with their barycentric coordinates. They therefore lie on the surface, and other
bodies do not pass between the nodes.

Membranes that deform have points at their nodes (`PointsOfNodes`), because their mass is lumped there: a damper that is
critical for the mass of a node stops it within a step. Points at the centroids of triangles would not detect patterns of
nodal motion that leave the centroids at rest, and nodes would rebound. The contact points of quadrilaterals are at nodal
positions without hourglass modes, and distribute forces with the same weights, so that forces on single nodes do not excite
these modes.
"""

from collections.abc import Callable

import numpy as np
from scipy import sparse

from pellucid.bodies.own_nodes.motion import NodalMotion
from pellucid.contact.contact_surface import ContactSurface, MovingTriangles
from pellucid.contact.sheets import SPACINGS
from pellucid.geometry.meshes.cells import Cells, vector_areas
from pellucid.grid.lattice import Grid

LONGEST_EDGE = 1.5
"""Longest admissible edge in cells. Elements are at most one cell long at the start; from two cells on, grid nodes between
their nodes have no contact. Longer faces of solids have more points, but only their corners carry a load."""


def nodes_about(grid: Grid, place: np.ndarray) -> np.ndarray:
    """Return the 8 grid nodes of the cell around each position [m], shape (n, 3), as node numbers of shape (8, n)."""
    lattice, thin = grid.lattice, grid.thin
    cell = np.floor((place - lattice.lower) * lattice.inverse_cell).astype(np.int64)
    cell = np.where(grid.periodic, cell % np.array(lattice.counts), cell)
    first = np.where(thin, 0, cell) @ np.array(lattice.strides)
    ends = [0 if flat else stride for flat, stride in zip(thin, lattice.strides, strict=True)]
    return np.array([grid.real_nodes(first + int(np.dot(way, ends))) for way in np.ndindex(2, 2, 2)])


def find_overlong(what: str, corners: np.ndarray, place: np.ndarray, grid: Grid, nodes: np.ndarray, effect: str) -> str | None:
    """Return a warning about the longest element near any of the grid nodes `nodes`, shape (n,); None if none is longer
    than `LONGEST_EDGE` cells.

    what: name of the elements, such as "body sheet touches another, its element"; corners: nodes of the elements, shape (m,
    3 or 4); place: positions of the nodes [m], shape (k, 3); effect: consequence and remedy. Lengths along an axis that is
    one cell thick are ignored.
    """
    lattice, thin = grid.lattice, grid.thin
    flat = np.where(thin, 0.0, place)[corners]
    length = np.linalg.norm(flat - np.roll(flat, 1, axis=1), axis=2).max(axis=1)
    near = np.asarray(np.isin(nodes_about(grid, place), nodes).any(axis=0))
    length[~near[corners].any(axis=1)] = 0.0
    worst = int(np.argmax(length))
    if length[worst] <= LONGEST_EDGE * lattice.cell:
        return None
    centre = ", ".join(f"{value:.4g}" for value in place[corners[worst]].mean(axis=0))
    return (
        f"where {what} {worst} at ({centre}) m is {length[worst]:.3g} m long, {length[worst] / lattice.cell:.2g} cells of "
        f"{lattice.cell:g} m: {effect}"
    )


ITERATIONS, ABOVE = 60, 1.02  # number of power iterations, and safety factor of their result
FLAT = 1e-6  # smallest extent along a thin axis that counts, relative to the largest extent
LONGEST = 1.0  # longest edge of the equal triangles, in cells


class PointsOfFaces(ContactSurface):
    """Contact surface with points within the triangles between nodes.

    triangles: corners, shape (t, 3); places, velocities: functions that return positions [m] and velocities [m/s] of the
    corners, shape (n, 3); take: function that adds forces on the corners [N], shape (n, 3), to the body; hard: True if all
    nodes follow prescribed motions.
    """

    serves_deformed = True

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
        self._middle = np.array(lattice.lower) + 0.5 * lattice.cell  # where points lie, however thick a slice is
        self.is_hard = hard
        self.triangles = moving_triangles(grid, triangles, places, velocities, take)
        corners = np.where(self._thin, 0.0, places())[triangles]
        edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        parts = np.maximum(1, np.ceil(edges / (LONGEST * lattice.cell) - 1e-9)).astype(np.int64)
        owner, shares = _middles(parts)
        self._owner, self._part = owner, 1.0 / parts[owner][:, None] ** 2
        m = len(owner)
        columns, rows = triangles[owner].ravel(), np.repeat(np.arange(m), 3)
        self._shares = sparse.csr_array((shares.ravel(), (rows, columns)), shape=(m, len(places())))
        self._to_corners = sparse.csr_array(self._shares.T)
        spacing = edges / parts
        if not self._thin.any():
            spacing = np.sqrt(np.linalg.norm(vector_areas(places(), triangles), axis=1)) / parts
        self.reach = SPACINGS * spacing[owner]
        self.place, self.velocity, self.area, self.slip = (np.zeros((m, 3)) for _ in range(4))
        self.begin()
        self._weights = self.sizes()

    def weights(self) -> np.ndarray:
        """Return the areas of the points that weight the contact forces [m²], shape (m,): the initial areas, or the present
        areas if the body does not deform (`hard`).
        """
        return self.sizes() if self.is_hard else self._weights

    def begin(self) -> None:
        """Update positions, velocities and areas of the contact points from the corners of the triangles. Along axes that are
        one cell thick, the points lie in the middle and have no area.
        """
        places = self._places()
        self.place[...], self.velocity[...] = self._shares @ places, self._shares @ self._velocities()
        self.area[...] = self._part * vector_areas(places, self._triangles)[self._owner]
        self.place[:, self._thin] = self._middle[self._thin]
        self.area[:, self._thin] = 0.0

    def corner_shares(self) -> sparse.csr_array:
        return self._shares

    def add_forces(self, force: np.ndarray) -> None:
        """Distribute the contact forces at the points [N], shape (m, 3), to the corners of the triangles."""
        self._take(self._to_corners @ force)

    def node_shares(self) -> sparse.csr_array:
        return self._shares if self.response is None else self.response.shares

    def respond_with(self, values: sparse.csr_array, motion: NodalMotion) -> None:
        """Set the object that computes the response of the contact points to forces on the nodes. values: weights of the nodes
        in the corners, shape (corners, nodes); motion: motion of the nodes.
        """
        self.response = NodalResponse(sparse.csr_array(self._shares @ values), motion)
        if self.triangles is not None:
            self.triangles = self.triangles._replace(response=NodalResponse(sparse.csr_array(values), motion))

    def mass_per_area_of(self, values: sparse.csr_array, mass: np.ndarray) -> float:
        """Return the smallest effective mass per area of the surface in contact with springs at all points [kg/m²].

        It is 1/λ for the largest eigenvalue λ of M⁻¹ Sᵀ N A Nᵀ S, with the weights S of the nodes in the points, the
        normals N and the areas A of the points.

        Parameters
        ----------
        values
            Weights of the nodes in the corners, shape (corners, nodes).
        mass
            Masses M of the nodes [kg].
        """
        shares, normal = sparse.csr_array(self._shares @ values), self.normals()
        vector, largest = shares.T @ normal, 0.0
        for _ in range(ITERATIONS):
            vector /= np.linalg.norm(vector)
            along = np.einsum("ij,ij->i", self.area, shares @ vector)
            vector = (shares.T @ (along[:, None] * normal)) / mass[:, None]
            largest = float(np.linalg.norm(vector))
        return 1.0 / (ABOVE * largest)


def moving_triangles(
    grid: Grid,
    triangles: np.ndarray,
    places: Callable[[], np.ndarray],
    velocities: Callable[[], np.ndarray],
    take: Callable[[np.ndarray], None],
) -> MovingTriangles | None:
    """Build the data of moving triangles for contact between surfaces of triangles; in a plane problem the surface is a band
    (strip) along the thin axis, which gets the depth of the cell.

    triangles: corners, shape (t, 3); places, velocities: functions that return positions [m] and velocities [m/s] of the
    corners, shape (n, 3); take: function that adds forces on the corners [N], shape (n, 3), to the body. Returns None if such
    contact is not supported: with several thin axes, and for surfaces that are not bands along the thin axis.
    """
    axes = np.flatnonzero(grid.thin)
    if not len(axes):
        return MovingTriangles(triangles, places, velocities, take)
    begun = places()
    extent = np.ptp(begun, axis=0)
    if len(axes) > 1 or not extent[axes[0]] > FLAT * extent.max():
        return None
    axis, lattice = int(axes[0]), grid.lattice
    across = lattice.lower[axis] + lattice.cell / extent[axis] * (begun[:, axis] - begun[:, axis].min())

    def as_deep_as_the_cell() -> np.ndarray:
        place = places().copy()
        place[:, axis] = across
        return place

    return MovingTriangles(triangles, as_deep_as_the_cell, velocities, take, grid.slice_thickness / lattice.cell)


class NodalResponse:
    """Computes the velocity changes of contact points by contact forces, through the nodes that move them. shares: weights of
    the nodes in the points, shape (m, nodes); motion: motion of the nodes.
    """

    def __init__(self, shares: sparse.csr_array, motion: NodalMotion) -> None:
        self.shares, self._to_nodes, self._motion = shares, sparse.csr_array(shares.T), motion

    def velocities(self, dt: float, pushed: np.ndarray | None) -> np.ndarray:
        velocity = self._motion.free_velocities(dt)
        if pushed is not None and pushed.any():
            velocity = velocity + self.answers(dt) * (self._to_nodes @ pushed)
        return np.asarray(self.shares @ velocity)

    def answers(self, dt: float) -> np.ndarray:
        return self._motion.answers(dt)


class PointsOfNodes(ContactSurface):
    """Contact surface of a membrane, with its nodes as contact points.

    Parameters
    ----------
    grid
        Grid of the case; its thin axes have no contact.
    cells
        Elements of the membrane.
    places, velocities, vector_areas
        Functions that return nodal positions [m], velocities [m/s] and vector areas [m²], shape (n, 3).
    weights
        Initial nodal areas [m²], shape (n,), which weight the contact forces.
    take
        Function that adds forces on the nodes [N], shape (n, 3), to the body.
    warning
        Method `contact_warning` of the body.
    shares
        Weights of the nodes in the contact points, shape (n, n); by default the points are at the nodes or, with
        quadrilaterals, at nodal positions without hourglass modes.
    """

    serves_deformed = True
    two_sided = True

    def __init__(
        self,
        grid: Grid,
        cells: Cells,
        places: Callable[[], np.ndarray],
        velocities: Callable[[], np.ndarray],
        vector_areas: Callable[[], np.ndarray],
        weights: np.ndarray,
        take: Callable[[np.ndarray], None],
        warning: Callable[[np.ndarray], str | None],
        shares: sparse.csr_array | None = None,
    ) -> None:
        self._grid, self._warning, triangles = grid, warning, cells.surface()
        self._smooth = _without_hourglass(cells.quadrilaterals, places()) if shares is None else shares
        self._from_smooth = None if self._smooth is None else sparse.csr_array(self._smooth.T)
        self._places, self._velocities, self._vector_areas, self._take = places, velocities, vector_areas, take
        self._thin, self._weights, n = np.array(grid.thin), weights, len(weights)
        self.is_plane = bool(self._thin.any())
        self.triangles = moving_triangles(grid, triangles, places, velocities, take)
        self._middle = np.array(grid.lattice.lower) + 0.5 * grid.lattice.cell
        self._corners = triangles if len(triangles) else cells.lines
        corners = np.where(self._thin, 0.0, places())[self._corners]
        longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
        self.reach = np.full(n, SPACINGS * float(np.median(longest)))
        self.place, self.velocity, self.area, self.slip = (np.zeros((n, 3)) for _ in range(4))
        self.begin()

    def weights(self) -> np.ndarray:
        """Return the initial nodal areas [m²], shape (n,), which weight the contact forces."""
        return self._weights

    def begin(self) -> None:
        """Update positions, velocities and areas of the contact points from the nodes. Along axes that are one cell thick, the
        points lie in the middle and have no area.
        """
        places, velocities = self._places(), self._velocities()
        if self._smooth is not None:
            places, velocities = self._smooth @ places, self._smooth @ velocities
        self.place[...], self.velocity[...], self.area[...] = places, velocities, self._vector_areas()
        self.place[:, self._thin] = self._middle[self._thin]
        self.area[:, self._thin] = 0.0

    def node_shares(self) -> sparse.csr_array:
        return sparse.eye_array(len(self.place), format="csr") if self._smooth is None else self._smooth

    def edges(self) -> np.ndarray:
        """Return the length of the longest element side at each node [m], shape (n,). For a square cut into two triangles
        it is the side, not the diagonal."""
        corners = np.where(self._thin, 0.0, self._places())[self._corners]
        sides = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
        longest = np.zeros(len(self.place))
        np.maximum.at(longest, self._corners, np.median(sides, axis=1)[:, None] if sides.shape[1] > 2 else sides)
        return longest

    def contact_warning(self, places: np.ndarray) -> str | None:
        return self._warning(nodes_about(self._grid, places).ravel())

    def add_forces(self, force: np.ndarray) -> None:
        """Add the contact forces at the points [N], shape (n, 3), to the forces on the nodes."""
        self._take(force if self._from_smooth is None else self._from_smooth @ force)


def _without_hourglass(quads: np.ndarray, places: np.ndarray) -> sparse.csr_array | None:
    """Return the weights of nodes in contact points that contain no hourglass modes of quadrilaterals, shape (n, n); None
    without quadrilaterals.

    quads: nodes of the quadrilaterals, shape (q, 4); places: nodal positions [m], shape (n, 3). From each corner, the mean of
    (γ·x) γ over its quadrilaterals is subtracted, with the unit vector γ that is orthogonal to all linear fields in the plane
    of the four corners. Linear fields are unchanged.
    """
    if not len(quads):
        return None
    corners = places[quads]
    _, _, axes = np.linalg.svd(corners - corners.mean(axis=1, keepdims=True))
    linear = np.einsum("qid,qad->qai", corners - corners.mean(axis=1, keepdims=True), axes[:, :2])
    linear = np.concatenate([np.full((len(quads), 1, 4), np.linalg.norm(linear, axis=(1, 2)).mean()), linear], axis=1)
    modes = np.linalg.svd(linear)[2][:, 3]
    n, counts = len(places), np.maximum(np.bincount(quads.ravel(), minlength=len(places)), 1)
    products = np.einsum("qi,qj->qij", modes, modes) / counts[quads][:, :, None]
    rows, columns = np.repeat(quads, 4, axis=1).ravel(), np.tile(quads, (1, 4)).ravel()
    modal = sparse.csr_array((products.ravel(), (rows, columns)), shape=(n, n))
    return sparse.csr_array(sparse.eye_array(n, format="csr") - modal)


def _middles(parts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the contact points of triangles that are divided into n² equal ones, n = `parts` for each: the triangle of each
    point, shape (m,), and its barycentric coordinates, shape (m, 3)."""
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
