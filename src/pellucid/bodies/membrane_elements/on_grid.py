"""Membranes of finite elements in a velocity field with other bodies: the nodes of the grid move them."""

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from pellucid.bodies.membrane_elements.surface import OF_NODES, ElementMembrane, ElementSurface
from pellucid.bodies.membranes.on_grid import BendsOnGrid, membrane_functions
from pellucid.bodies.membranes.plane_slice import is_loop
from pellucid.bodies.membranes.plate_bending import PlateBending
from pellucid.bodies.own_nodes.contact_surface import PointsOfNodes
from pellucid.bodies.own_nodes.kernels import power
from pellucid.bodies.points_on_grid import MeshOnGrid
from pellucid.contact.contact_body import WarnsOfContact
from pellucid.energy import FIRST_LOAD
from pellucid.geometry.meshes.enclosure import inside
from pellucid.grid.model import GridCase
from pellucid.grid.transfer import scatter_vectors
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer
from pellucid.parts.capabilities import TakesPressure
from pellucid.step.limit import StepLimit, springs_of_contact, tightest

if TYPE_CHECKING:
    from pellucid.bodies.membrane_elements.forces_ahead import ForcesAhead
    from pellucid.bodies.membrane_elements.model import MembraneElementsCase


class ElementsOnGrid(ElementMembrane, BendsOnGrid, MeshOnGrid, TakesPressure, WarnsOfContact):
    """A membrane of elements in a shared velocity field; its nodes are material points, as for membrane points.

    Mass, momentum and nodal forces are scattered to the grid nodes, and velocities are gathered. The strains of the elements
    follow from the motion of their nodes on the mesh, not from the velocity gradient on the grid.
    """

    sorting_cost = 3.0  # few of its loops are vectorized
    forces_ahead: "ForcesAhead | None" = None
    """Extrapolates its internal forces where viscosity dominates its motion; None where forces at the start of a step act."""

    def __init__(
        self,
        case: "MembraneElementsCase",
        grid_case: GridCase,
        velocity_field: VelocityField,
        velocity_transfer: VelocityTransfer,
    ) -> None:
        self.surface = surface = ElementSurface(case, grid_case)
        if (limit := case.in_liquid(grid_case.cell)) is not None:
            surface.move_in_liquid(limit, case.mesh())
        self.viscosity_share = case.viscosity_share(surface.wave_at_start)
        """1 where viscosity dominates its motion, 0 where inertia does, see `share_of_viscosity`."""
        self.bending, self.start_positions = surface.bending, surface.vertices
        self.element_arrays = surface.arrays
        self.areal_density = surface.areal_density
        n = len(surface.vertices)
        arrays = {  # of its own: points are stored in another order than nodes of the mesh
            "id": np.arange(n),
            "position": surface.vertices.copy(),
            "velocity": case.initial_velocity(surface.vertices),
            "mass": surface.node_mass.copy(),
            "volume": surface.mesh.at_nodes(surface.arrays["volume"]),  # for contact of its field with others
        }
        functions = membrane_functions(velocity_field.grid, isinstance(surface.bending, PlateBending))
        self._closed, self._curving = case.surface.closed, surface.in_liquid
        if any(grid_case.thin()):
            self._closed = is_loop(surface.vertices, surface.cells.surface(), grid_case)
        self.node_velocity = arrays["velocity"].copy()
        """Straining velocity of the nodes in the last step, in mesh order [m/s], shape (n, 3). Nodal forces on the grid do
        work on this velocity."""
        super().__init__(case.name, velocity_field, functions, velocity_transfer, arrays)

    def _follow_order(self) -> None:
        self.surface.bind(self.arrays["id"], self.storage.shared.first)

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(arrays)
        self.node_velocity[...] = arrays["node_velocity"]
        self.surface.go_on(self.points.position)

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {**super().state_arrays(), "node_velocity": self.node_velocity}

    def contact_warning(self, nodes: np.ndarray) -> str | None:
        """Return a warning if elements in contact at the grid nodes `nodes` are larger than the grid cells; None otherwise."""
        return self.surface.overlong(self.name, self.places(), self.grid, nodes)

    # contact

    def make_contact_surface(self, column: int) -> PointsOfNodes | None:
        if self.constraint is not None:
            return None

        def vector_areas() -> np.ndarray:
            return self.vector_areas()[self.order()]

        areas = self.surface_areas()
        how = vector_areas, areas, self._contact_load(column), self.contact_warning
        surface = PointsOfNodes(self.grid, self.surface.cells, self.places, lambda: self.node_velocity, *how)
        surface.half_width = self.surface.contact_reach
        surface.mass_per_area, surface.rate = self.areal_density, self.totals.rate
        self.contact_surface = surface
        return surface

    def encloses(self, places: np.ndarray) -> bool:
        if not self._closed:
            return False
        own, thin = self.places(), np.array(self.grid.thin)
        level = np.where(thin, 0.5 * (own.min(axis=0) + own.max(axis=0)), places)  # nothing varies along the thin axis
        return bool(inside(level, own, self.surface.cells.surface()).all())

    def add_pressure(self, pressure: float, column: int) -> None:
        forces = np.zeros((self.n_points, 3))
        self.surface.add_pressure_forces(self.points.position, pressure, forces)
        scatter_vectors(self.n_slabs, self.mapped, forces, self.velocity_field.load_row(column - FIRST_LOAD))

    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        if inertia:
            self._to_grid.scatter(inertia=True, force=False)
        if force:
            forces = self._internal_forces()
            if self.forces_ahead is not None:
                forces = self.forces_ahead.extrapolate(forces, self.arrays["id"])
            self._scatter_internal_forces(forces, self.grid.nodes.force)

    def _internal_forces(self) -> np.ndarray:
        forces = np.zeros((self.n_points, 3))
        self.surface.add_internal_forces(self.points.position, forces)
        return forces

    def update_positions(self, dt: float) -> None:
        before = self.points.position.copy()
        self._move_by_nodes(dt)
        self.prescribe_positions()
        self.storage.complete("position")
        moved = self.points.position - before
        velocity = moved / dt if dt > 0.0 else moved  # without a step nothing moved
        if dt > 0.0:
            self.node_velocity[self.arrays["id"]] = velocity
        rate = self.surface.strain(self.points.position, velocity, dt, self.totals)
        ahead = 0.0 if self.forces_ahead is None else self.forces_ahead.share
        self.totals.half_power = (0.5 - ahead) * power(self._internal_forces(), velocity)
        self.arrays["volume"][:] = self.surface.mesh.at_nodes(self.element_arrays["volume"])[self.arrays["id"]]
        fastest = float(np.sqrt(np.max(np.sum(self.points.velocity**2, axis=1))))
        bends = 1.0 / self._bending_limit().step
        self._bound_rate(max(rate, fastest * self.grid.lattice.inverse_cell, bends, self._contact_rate))

    def signal_limit(self) -> StepLimit:
        limits = (
            self.surface.step_limit(self.grid, self.fastest()),
            self._bending_limit(),
            springs_of_contact(self._contact_rate),
        )
        return tightest(limits)

    def stored_field(self, name: str) -> np.ndarray:
        if name in OF_NODES:
            return super().stored_field(name)
        return self.surface.field(name, self.points.position, self.points.mass)
