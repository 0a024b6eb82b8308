"""Surfaces with a mesh whose nodes move with the nodes of the grid."""

from collections.abc import Callable, Sequence

import numpy as np

from pellucid.bodies.own_nodes.contact_surface import PointsOfNodes
from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.contact.contact_surface import ContactSurface
from pellucid.energy import FIRST_LOAD
from pellucid.grid.transfer import scatter_vectors
from pellucid.parts.capabilities import BoundByContact, HasContactSurface


class MeshOnGrid(PointsOnGrid, HasContactSurface, BoundByContact):
    """Base class of films and membranes of elements in a shared velocity field. The motion of the nodes strains them, not the
    velocity gradient of the grid.
    """

    contact_surface: PointsOfNodes | None = None
    _contact_rate = 0.0
    """Reciprocal of the largest step that resolves the contact springs [1/s]."""

    def _contact_load(self, column: int) -> Callable[[np.ndarray], None]:
        """Return the function that adds contact forces on the nodes [N], shape (n, 3), in the order of the mesh; column: place
        of the work of contact forces in arrays of works.
        """

        def add(force: np.ndarray) -> None:
            load = self.velocity_field.load_row(column - FIRST_LOAD)
            scatter_vectors(self.n_slabs, self.mapped, force[self.arrays["id"]], load)

        return add

    def bound_by_contact(self, touching: Sequence[ContactSurface]) -> None:
        """Limit the time step by the contact springs if the contact surface is one of `touching`, the surfaces with possible
        contact; otherwise remove this surface.
        """
        if self.contact_surface is not None and any(other is self.contact_surface for other in touching):
            self._contact_rate = self.contact_surface.rate
        else:
            self.contact_surface = None

    def begin_stress(self, dt: float, move: bool) -> None:
        """Do nothing: the motion of the nodes strains the body, in `end_stress`."""

    def end_stress(self, dt: float, move: bool) -> None:
        """Move the nodes over dt [s] if `move` is True, and update strains, energies and step limit; with dt = 0, only compute
        energies and step limit.
        """
        if move or dt == 0.0:
            self.update_positions(dt)

    @property
    def _moving_velocity(self) -> np.ndarray:
        """Nodal velocities of the grid that strain bodies [m/s], shape (nodes, 3). The body moves with these velocities, so
        that no energy is lost between its motion and the work of its forces."""
        return self.grid.nodes.strain_velocity
