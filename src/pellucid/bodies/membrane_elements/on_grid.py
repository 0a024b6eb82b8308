"""Membranes of finite elements in a velocity field with other bodies: the nodes of the grid move them."""

from typing import Any

import numpy as np

from pellucid.bodies.membrane_elements import nodes as element_nodes
from pellucid.bodies.membrane_elements.model import MembraneElementsCase
from pellucid.bodies.membrane_elements.surface import ElementBody
from pellucid.grid import transfer
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase


class ElementsOnGrid(ElementBody):
    """Elements that share a velocity field: their nodes are points of it, as those of membrane points are.

    Mass, momentum and nodal forces go to the nodes of the grid, velocities come back from there, and the elements are strained
    by how their nodes were moved: by mesh and not by the gradient of the grid's velocity.
    """

    def __init__(self, case: MembraneElementsCase, grid_case: GridCase, grid: Grid, velocity_transfer: Any) -> None:
        super().__init__(case, grid_case, grid, velocity_transfer, {})

    def bind(self) -> None:
        """Take up arrays that were replaced; the nodes have volumes, for contact of their field with others."""
        self.arrays.setdefault("volume", self._mesh.at_nodes(self.element_arrays["volume"]))
        super().bind()

    def press(self, outside_load: np.ndarray, pressure: float) -> None:
        """Add the forces of a pressure [Pa] along the normals to those on the grid's nodes [N], shape (nodes, 3)."""
        forces = np.zeros((self.n_points, 3))
        self._add_pressure_forces(forces, pressure)
        element_nodes.spread(self.n_slabs, self.mapped, forces, outside_load)

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Mass and momentum, internal forces."""
        if inertia:
            transfer.scatter(self.n_slabs, self.mapped, 1, 0)
        if force:
            forces = np.zeros((self.n_points, 3))
            self._add_internal_forces(forces)
            element_nodes.spread(self.n_slabs, self.mapped, forces, self.grid.nodes.force)

    def update_positions(self, dt: float) -> None:
        """New positions, and what the elements make of them."""
        before = self.points.position.copy()
        # by the velocity that strains points: in MUSL that of the points' own momentum, which costs no energy
        transfer.update_positions(self.n_slabs, self.mapped, self.grid.nodes.strain_velocity, dt)
        self.place()
        moved = self.points.position - before
        self._strain(moved / dt if dt > 0.0 else moved, dt)  # without a step nothing moved
        self.arrays["volume"][:] = self._mesh.at_nodes(self.element_arrays["volume"])[self.arrays["id"]]
        fastest = float(np.sqrt(np.max(np.sum(self.points.velocity**2, axis=1))))
        self._bound_rate(max(self._element_rate, fastest * self.grid.lattice.inverse_cell))
