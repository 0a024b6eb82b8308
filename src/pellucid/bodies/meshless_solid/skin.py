"""Contact of a body with nodal shape functions through material points on its surface.

Contact applies to material points, x_k = Σ_a S_ka x_a with S_ka = p_a(X_k), not to the nodal coefficients x_a, which may lie
off the surface. Points on the outer faces (`skin_points`) with velocities Σ_a S_ka v_a are scattered to the grid. Material
within a cell of the surface is therefore not held in contact, as it would be if all nodes were scattered. Velocity increments
from contact are mapped back with the same weights, m_a Δv_a = Σ_k S_ka m_k Δv_k, which conserves momentum since Σ_a S_ka =
1.

The velocity of a grid node is a mean, and mapping an increment to the points and back returns only a part: Δv_I = Σ_k N_I m_k
(SΔv)_k / m_I, with the grid functions N_I. Without a correction, points under a lasting load would creep into the other body.
The grid nodes therefore get the velocities of the body's response, and contact continues from these (`SkinResponse`).
"""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy import uintp
from scipy import sparse

from pellucid.approximants.nodal.contract import Evaluator
from pellucid.bodies.meshless_solid.prescribed import values_at
from pellucid.bodies.own_nodes.contact_surface import PointsOfFaces, find_overlong
from pellucid.bodies.own_nodes.grid_transfer import GridCoupling
from pellucid.bodies.own_nodes.motion import NodalMotion
from pellucid.contact.contact_body import ContactResponse, WarnsOfContact
from pellucid.contact.detection import allocate_numbers, mark_stencils
from pellucid.geometry.meshes.cells import cells_of_faces, outer_faces
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.grid.lattice import Grid, Nodes
from pellucid.grid.stencil import functions_at, node_at, stencil_of
from pellucid.grid.transfer import gather_vectors
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.ranks.domain import domain
from pellucid.state import of_owner, with_owner

SMALLEST = 1e-12  # smallest weight that is kept: functions of nodes off a face vanish on it, except for round-off


class SkinPoints(NamedTuple):
    """m contact points on the surface of a solid: its nodes and, on faces longer than a limit, points of a lattice.

    The mass of a point is its effective mass in contact, a share of the masses of the nodes that move it. For each node a, Σ_k
    S_ka m_k ≤ m_a, so that contact adds no energy.
    """

    values: sparse.csr_array  # (m, n) weights S_ka = p_a(x_k) of the nodes a at the points k
    mass: np.ndarray  # (m,) effective masses [kg]
    is_node: np.ndarray  # (m,) True for a node of the mesh
    faces: np.ndarray  # (f, 3) points at the corners of the outer faces
    triangles: np.ndarray  # (t, 3) points at the corners of the triangles into which the faces are divided


def skin_points(
    mesh: SimplexMesh, evaluator: Evaluator, mass: np.ndarray, longest: float, closed: Sequence[np.ndarray] = ()
) -> SkinPoints:
    """Return contact points at most `longest` [m] apart on the outer faces of a mesh with nodal masses [kg], shape (n,).

    evaluator: shape functions at any point; closed: masks, shape (n,), of sets of nodes that stay on a wall; faces with all
    nodes in one set have no contact.
    """
    faces = outer_faces(mesh.cells)
    behind = [on_wall[faces].all(axis=1) for on_wall in closed]
    faces = faces[~np.any(behind, axis=0)] if behind and not np.any(behind, axis=0).all() else faces
    owner = cells_of_faces(mesh.cells, faces)
    corners = mesh.nodes[faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    parts = np.maximum(1, np.ceil(edges / longest * (1.0 - 1e-9)).astype(np.int64))
    at_nodes, cell_of_node = np.zeros(len(mesh.nodes)), np.zeros(len(mesh.nodes), np.int64)
    np.maximum.at(cell_of_node, faces.ravel(), np.repeat(owner, 3))
    nodes, by_corner = np.unique(faces, return_inverse=True)
    by_corner = by_corner.reshape(-1, 3)
    places, cells, areas, triangles, count = [], [], [], [], len(nodes)
    for n in np.unique(parts):
        here = parts == n
        numbers = []
        lattice, within = _lattice(int(n))
        for shares, weight in lattice:
            corner = np.flatnonzero(shares == 1.0)
            if len(corner):
                np.add.at(at_nodes, faces[here, corner[0]], weight * area[here])
                numbers.append(by_corner[here, corner[0]])
            else:
                places.append(np.einsum("k,fki->fi", shares, corners[here]))
                cells.append(owner[here])
                areas.append(weight * area[here])
                numbers.append(count + np.arange(here.sum()))
                count += int(here.sum())
        triangles.append(np.array(numbers)[within].transpose(2, 0, 1).reshape(-1, 3))
    values = values_at(
        mesh, evaluator, np.concatenate([cell_of_node[nodes], *cells]), np.concatenate([mesh.nodes[nodes], *places])
    )
    values.data[abs(values.data) < SMALLEST] = 0.0
    values.eliminate_zeros()
    share = np.concatenate([at_nodes[nodes], *areas])
    mass_of_points = share * _least_depth(values, share, mass)
    return SkinPoints(values, mass_of_points, np.arange(len(share)) < len(nodes), by_corner, np.concatenate(triangles))


def _lattice(n: int) -> tuple[list[tuple[np.ndarray, float]], np.ndarray]:
    """Return the points of a triangle divided into n² equal triangles, as pairs of barycentric coordinates and fraction of
    the area; and the corners of the equal triangles, shape (n², 3)."""
    found: list[tuple[np.ndarray, float]] = []
    number: dict[tuple[int, int], int] = {}
    for i in range(n + 1):
        for j in range(n + 1 - i):
            shares = np.array([i, j, n - i - j]) / n
            about = {3: 6, 2: 3, 1: 1}[int((shares > 0.0).sum())]  # of the small triangles
            number[i, j] = len(found)
            found.append((shares, about / (3.0 * n * n)))
    upright = [((i + 1, j), (i, j + 1), (i, j)) for i, j in number if i + j < n]
    turned = [((i, j), (i - 1, j), (i, j - 1)) for i, j in number if i and j]
    return found, np.array([[number[corner] for corner in triangle] for triangle in upright + turned])


def _least_depth(values: sparse.csr_array, share: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Return the effective mass per area of each contact point [kg/m²], shape (m,): the smallest value of m_a / Σ_k S_ka A_k
    among the nodes a that move it.

    values: weights S_ka of the n nodes in the m points, shape (m, n); share: areas A_k of the points [m²]; mass: nodal masses
    m_a [kg], shape (n,).
    """
    of_node = values.T @ share
    depth = np.where(of_node > 0.0, mass / np.where(of_node > 0.0, of_node, 1.0), np.inf)
    return np.minimum.reduceat(depth[values.indices], values.indptr[:-1])


@kernel()
def _list_weights(mapped, slot, near, listed, first, column, weight):
    """List the surface points whose grid functions are not zero at some of the grid nodes in contact, as a sparse matrix: point
    numbers into `listed`, starts of their entries into `first`, and numbers of the grid nodes and weights into `column` and
    `weight`. Returns the number of points.

    mapped: data of the surface points for transfers to the grid; slot: number of each of the grid nodes in contact in the
    result, negative for other nodes; near: for each first node of a stencil (the nodes with non-zero functions at a point) 0 if
    the stencil contains no node in contact.
    """
    functions, lattice, x = mapped.functions, mapped.lattice, mapped.points.position
    n = entries = 0
    for p in range(len(x)):
        start, numbers = functions_at(functions, lattice, (x[p, 0], x[p, 1], x[p, 2]))
        if near[uintp(start)] == 0:
            continue
        about = stencil_of(functions, start, numbers)
        wx, wy, wz = about.wx, about.wy, about.wz
        listed[n], first[n] = p, entries
        n += 1
        for a in range(len(wx)):
            for b in range(len(wy)):
                for c in range(len(wz)):
                    e = slot[node_at(about, lattice, a, b, c)]
                    if e >= 0:
                        column[entries], weight[entries] = e, wx[a] * wy[b] * wz[c]
                        entries += 1
    first[n] = entries
    return n


class SkinResponse:
    """Computes the velocity changes of grid nodes that follow from contact impulses on a meshless body: increments at the
    grid nodes are mapped to the nodes of the body through the surface points, and the resulting velocities are mapped back.

    surface: coupling of the surface points to the grid; mass: masses of the surface points [kg], shape (m,); values: shape
    functions S_ka of the n nodes at the surface points, shape (m, n); inertia: masses of the nodes [kg], shape (n,);
    prescribed: 0 for free components, shape (n, 3).

    Increments Δv_I of grid nodes I are mapped to the points k of the surface and to the nodes a of the body; the resulting
    velocities of the points are mapped back to the nodes of the grid (symbols as in `skin`, with the grid functions N_I and
    masses m):

        Δv_a = Σ_I K_Ia Δv_I / m_a,  m_I Δv'_I = Σ_a K_Ia Δv_a,  K_Ia = Σ_k N_I(x_k) m_k S_ka .

    Contact applies this repeatedly in a step, always at the same few nodes, so K is computed once, for these nodes only.
    """

    def __init__(
        self, surface: GridCoupling, mass: np.ndarray, values: sparse.csr_array, inertia: np.ndarray, prescribed: np.ndarray
    ) -> None:
        self._surface, self._mass, self._values = surface, mass, values
        self._inertia, self._prescribed = inertia, prescribed
        grid, m = surface.velocity_field.grid, len(mass)
        self._nodes: Nodes = grid.nodes
        self._reach = tuple(function.stencil for function in surface.functions)
        self._lattice = grid.lattice
        self._slot, self._near = allocate_numbers(grid.n_nodes)
        most = m * int(np.prod(self._reach))
        self._listed, self._first = np.empty(m, np.int64), np.empty(m + 1, np.int64)
        self._column, self._weight = np.empty(most, np.int64), np.empty(most)

    def begin(self, at: np.ndarray) -> None:
        """Compute the matrix Σ_k N_I(x_k) m_k S_ka that maps velocity increments of the grid nodes I = `at` in contact,
        shape (k,), to impulses on the nodes a of the body, through surface points x_k with masses m_k; N: functions of the
        grid, S: functions of the body. Called in each step after the momentum of the grid nodes was advanced."""
        K = self._matrix(at)
        used, column = np.unique(K.indices, return_inverse=True)
        self._from_body = sparse.csr_array((K.data, column, K.indptr), shape=(len(at), len(used)))
        self._to_body = sparse.csr_array(self._from_body.T)
        self._mobility = (self._prescribed[used] == 0) / self._inertia[used, None]
        nodes, self._at = self._nodes, at
        self._trial = nodes.velocity[at] - nodes.velocity_increment[at]
        self._share = (nodes.constrained[at] == 0) / nodes.mass[at, None]

    def _matrix(self, at: np.ndarray) -> sparse.csr_array:
        mark_stencils(at, self._slot, self._near, self._reach, self._lattice, True)
        to = self._listed, self._first, self._column, self._weight
        n = _list_weights(self._surface.mapped, self._slot, self._near, *to)
        mark_stencils(at, self._slot, self._near, self._reach, self._lattice, False)
        listed, first = self._listed[:n], self._first[: n + 1]
        given = self._weight[: first[n]] * np.repeat(self._mass[listed], np.diff(first))
        points = sparse.csr_array((given, self._column[: first[n]], first), shape=(n, len(at)))
        return sparse.csr_array(sparse.csr_array(points.T) @ self._values[listed])

    def give(self) -> None:
        """Set the velocities of the grid nodes in contact to the response of the body to all velocity increments from contact
        in this step.
        """
        nodes, at = self._nodes, self._at
        of_body = self._mobility * (self._to_body @ nodes.velocity_increment[at])
        nodes.velocity[at] = self._trial + self._share * (self._from_body @ of_body)


class Skin(WarnsOfContact):
    """The contact surface of a meshless solid on the grid.

    coupling: transfers of the nodal coefficients; arrays: arrays of the body, including masses; volume: nodal volumes, shape
    (n,) [m³]; at_nodes: values of the shape functions at the nodes, shape (n, n); points: contact points.
    """

    is_surface = False

    def __init__(
        self,
        name: str,
        coupling: GridCoupling,
        arrays: Mapping[str, np.ndarray],
        volume: np.ndarray,
        at_nodes: sparse.csr_array,
        points: SkinPoints,
    ) -> None:
        self.name, self.functions, self._field = name, coupling.functions, coupling.velocity_field
        self._position, self._velocity = arrays["position"], arrays["velocity"]
        self._increment, mass = coupling.increment, arrays["mass"]
        self._mass = mass[:, None]
        self._values, self._shares = points.values, sparse.csr_array(points.values.T)
        m, added = len(points.mass), ~points.is_node
        self._x, self._v = np.zeros((m, 3)), np.zeros((m, 3))
        self._at_points, self._point_mass = np.zeros((m, 3)), points.mass[:, None]
        # contact detection uses the whole body: inner nodes define where it lies
        self._all = sparse.csr_array(sparse.vstack([at_nodes, points.values[added]]))
        density = float(mass.sum() / volume.sum())
        volumes = np.concatenate([volume, points.mass[added] / density])
        self._everywhere = np.zeros((len(volumes), 3))
        self.follow()
        self._faces, self._triangles = points.faces, points.triangles
        self.surface = GridCoupling(self._field, self.functions, self._x, self._v, points.mass, whole=True)
        still = np.zeros_like(self._everywhere)
        self.whole = GridCoupling(self._field, self.functions, self._everywhere, still, density * volumes, volumes, whole=True)
        self._response = SkinResponse(self.surface, points.mass, self._values, mass, arrays["prescribed"])
        self._first = True

    def surface_of(self, grid: Grid, loads: np.ndarray, motion: NodalMotion, hard: bool) -> PointsOfFaces:
        """Build the contact surface that detects contact between surfaces; its forces act at points of the outer faces.

        grid: the grid; loads: forces on the nodes [N], shape (n, 3), to which the contact forces are added; motion: motion of
        the nodes under these loads; hard: True if all nodes are prescribed.
        """

        def take(force: np.ndarray) -> None:
            loads[...] += self._shares @ force

        def velocities() -> np.ndarray:
            return np.asarray(self._values @ self._velocity)

        surface = PointsOfFaces(grid, self._triangles, lambda: self._x, velocities, take, hard)
        surface.mass_per_area = surface.mass_per_area_of(self._values, motion.inertia)
        if not hard:
            surface.respond_with(self._values, motion)
        return surface

    def follow(self) -> None:
        """Update positions and velocities of the surface points by interpolation between the nodes with the shape functions,
        which reproduce the initial positions of the points.
        """
        self._x[:], self._v[:] = self._values @ self._position, self._values @ self._velocity
        if self._field.touches_on_nodes:
            self._everywhere[:] = self._all @ self._position

    def begin(self) -> None:
        """Prepare a step: sort the surface points by grid cell again if some have left their slab (layer of cells)."""
        if self._field.touches_on_nodes:
            self.surface.sort_if_needed()
            self.whole.sort_if_needed()

    def scatter(self, force: np.ndarray) -> None:
        """Scatter mass and momentum of the surface points to the grid, and the forces on the nodes of the body [N], shape (n,
        3)."""
        self._first = True
        self._v[:] = self._values @ self._velocity
        self.surface.scatter(self._point_mass * (self._values @ (force / self._mass)))

    def scatter_momentum(self) -> None:
        """Scatter only the momentum of the surface points to the grid, after the nodal velocities changed."""
        self._v[:] = self._values @ self._velocity
        self.surface.scatter_momentum()

    def gather(self) -> np.ndarray:
        """Return the velocity increments of the nodes from contact in this step [m/s], shape (n, 3)."""
        if not self._field.pressed:
            self._increment.fill(0.0)
            return self._increment
        nodes = self._field.grid.nodes
        domain.spread(nodes.velocity_increment)
        gather_vectors(self.surface.n_slabs, self.surface.mapped, nodes.velocity_increment, self._at_points)
        np.divide(self._shares @ (self._point_mass * self._at_points), self._mass, out=self._increment)
        return self._increment

    @property
    def contact_response(self) -> ContactResponse:
        return self

    def respond(self) -> None:
        if self._first:
            at = self._field.awaiting
            self._response.begin(domain.of_nodes(at, at))
        domain.spread(self._field.grid.nodes.velocity_increment)
        self._response.give()
        self._first = False

    def finish(self) -> None:
        """Do nothing: the body gathers its increments from the grid nodes independently of their velocities."""

    # data for contact detection

    @property
    def n_points(self) -> int:
        """Number of points that contact detection uses: all nodes of the body and the points on its faces."""
        return len(self._everywhere)

    @property
    def mapped(self) -> Bundle:
        """Data for kernels, for transfers to the grid, of the points that contact detection uses: all nodes of the body and the
        points on its faces.
        """
        return self.whole.mapped

    @property
    def n_slabs(self) -> int:
        """Number of slabs (layers of grid cells) by which the points that contact detection uses (all nodes, points on faces)
        are sorted.
        """
        return self.whole.n_slabs

    def half_width(self) -> tuple[float, float, float]:
        """Return zeros: contact begins at the points, which lie on the surface."""
        return 0.0, 0.0, 0.0

    def contact_warning(self, nodes: np.ndarray) -> str | None:
        """Return a warning if outer faces in contact at the grid nodes `nodes` are larger than the grid cells; None
        otherwise.
        """
        what, effect = (
            f"body {self.name} touches another, its outer face",
            "other bodies penetrate this face; refine the mesh near it",
        )
        return find_overlong(what, self._faces, self._x, self._field.grid, nodes, effect)

    # step and checkpoint

    def update(self) -> None:
        """Move the surface points with the nodes of the body, at the end of a step."""
        self.follow()
        if self._field.touches_on_nodes:
            for coupling in (self.surface, self.whole):
                coupling.check_positions()

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays for a checkpoint: the orders in which nodes and surface points are sorted by grid cell."""
        parts = {"surface": self.surface, "whole": self.whole}
        return {
            name: array for part, c in parts.items() for name, array in with_owner(f"skin/{part}", c.state_arrays()).items()
        }

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the orders of nodes and surface points from the arrays of a checkpoint (see `state_arrays`); call it after
        the nodal coefficients were restored.
        """
        self.follow()
        self.surface.restore(of_owner("skin/surface", arrays))
        self.whole.restore(of_owner("skin/whole", arrays))
