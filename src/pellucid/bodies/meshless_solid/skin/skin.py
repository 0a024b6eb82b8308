"""Contact of a body with nodal shape functions through material points on its surface.

Contact applies to material points, x_k = Σ_a S_ka x_a with S_ka = p_a(X_k), not to the nodal coefficients x_a, which may lie
off the surface. Points on the outer faces (`skin_points`) with velocities Σ_a S_ka v_a are scattered to the grid. Material
within a cell of the surface is therefore not held in contact, as it would be if all nodes were scattered. Velocity increments
from contact are mapped back with the same weights, m_a Δv_a = Σ_k S_ka m_k Δv_k, which conserves momentum since Σ_a S_ka =
1.

The velocity of a grid node is a mean, and mapping an increment to the points and back returns only a part: Δv_I = Σ_k N_I m_k
(SΔv)_k / m_I, with the grid functions N_I. Without a correction, points under a lasting load would creep into the other body.
The grid nodes therefore get the velocities of the body's response, and contact continues from these (`skin_response`).
"""

from collections.abc import Mapping

import numpy as np
from scipy import sparse

from pellucid.bodies.meshless_solid.skin.points import SkinPoints
from pellucid.bodies.meshless_solid.skin.response import SkinResponse
from pellucid.bodies.own_nodes.contact_surface import PointsOfFaces
from pellucid.bodies.own_nodes.grid_transfer import GridCoupling
from pellucid.bodies.own_nodes.motion import NodalMotion
from pellucid.bodies.own_nodes.overlong import find_overlong
from pellucid.contact.contact_body import ContactResponse, WarnsOfContact
from pellucid.grid.lattice import Grid
from pellucid.grid.vectors import gather_vectors
from pellucid.jit.bundle import Bundle
from pellucid.ranks.domain import domain
from pellucid.state import of_owner, with_owner


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
        self._follow()
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

    def _follow(self) -> None:
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
        self._follow()
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
        self._follow()
        self.surface.restore(of_owner("skin/surface", arrays))
        self.whole.restore(of_owner("skin/whole", arrays))
