"""Membranes of finite elements whose nodes move by their own equation of motion (Lian, Liu & Zhang 2014, section 4)."""

from collections.abc import Collection, Mapping
from math import hypot
from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse

from pellucid.bodies.membrane_elements.equilibrium import MembraneSystem
from pellucid.bodies.membrane_elements.surface import OF_NODES, ElementMembrane, ElementSurface
from pellucid.bodies.membranes.bending import support_bending
from pellucid.bodies.own_nodes.body import ExplicitNodes
from pellucid.bodies.own_nodes.contact_surface import NodalResponse, PointsOfFaces, PointsOfNodes
from pellucid.bodies.own_nodes.kernels import CHUNK
from pellucid.contact.contact_body import WarnsOfContact
from pellucid.energy import FIRST_LOAD
from pellucid.parts.body import Placement
from pellucid.parts.capabilities import HasContactSurface, TakesPressure
from pellucid.parts.elastic_system import PathSystem
from pellucid.step.limit import StepLimit, bending_in_mesh, springs_of_contact, told

if TYPE_CHECKING:
    from pellucid.bodies.membrane_elements.model import MembraneElementsCase


class MembraneElements(ElementMembrane, ExplicitNodes, TakesPressure, HasContactSurface, WarnsOfContact):
    """A membrane of elements in its own velocity field: its nodes move by their own forces; the grid is used for contact
    only."""

    def __init__(self, case: "MembraneElementsCase", placement: Placement) -> None:
        self.name, self._has_energy = case.name, case.material.has_energy
        self.surface = surface = ElementSurface(case, placement.grid_case)
        self.element_arrays = surface.arrays
        self.areal_density = surface.areal_density
        super().__init__(surface.vertices.copy(), case.initial_velocity(surface.vertices), surface.node_mass, placement)
        surface.bind(self.arrays["id"], np.minimum(np.arange(self.motion.chunks + 1) * CHUNK, len(surface.vertices)))
        self.renew_totals()

    def volumes(self) -> np.ndarray:
        return self.surface.mesh.at_nodes(self.element_arrays["volume"])

    # conditions

    def complete(self) -> None:
        """Apply the clamps of supports to the bending of the membrane at constrained nodes, after all conditions are known."""
        if self._support_bending():
            self.renew_totals()
        super().complete()

    def let_go(self, supports: Collection[int]) -> None:
        """Release supports with these numbers, and the bending clamps at their nodes."""
        super().let_go(supports)
        if self._support_bending():
            self._find_forces()

    def _support_bending(self) -> bool:
        return support_bending(self.surface.bending, self.motion.groups(), self.motion.on_symmetry_planes())

    # the step

    def add_pressure(self, pressure: float, column: int) -> None:
        self.surface.add_pressure_forces(self.arrays["position"], pressure, self.motion.loads[column - FIRST_LOAD])

    def update(self, dt: float) -> None:
        super().update(dt)
        rate = self.surface.strain(self.arrays["position"], self.arrays["velocity"], dt, self.totals)
        self._find_forces()
        self._count_power()
        self.totals.rate = max(hypot(rate, self._bending_rate), self.motion.crossing, self.contact_rate)

    def elastic_system(self) -> PathSystem:
        """Return energy, forces and stiffness for equilibria; only for triangles."""
        surface, stiffness = self.surface, self.mass * self.surface.wave_at_start**2
        given = surface, self.arrays["position"], self.motion, stiffness, self._take_equilibrium, self.totals
        return MembraneSystem(*given, self._has_energy)

    def _take_equilibrium(self, dt: float) -> None:
        """Update everything that depends on the positions of the nodes after a new equilibrium; dt: step of the time of the
        loads [s]."""
        self.motion.sum_at_rest(self.totals, dt)
        self.totals.half_power = 0.0

    def step_limit(self) -> StepLimit:
        limits = [self.surface.step_limit(self.grid, max(self.fastest(), self.motion.top_speed))]
        bends = [bending_in_mesh(self._bending_rate)] if self._bending_rate > 0.0 else []
        return told(self.totals.rate, [*limits, *bends, springs_of_contact(self.contact_rate)])

    def _find_forces(self) -> None:
        self.motion.internal.fill(0.0)
        self.surface.add_internal_forces(self.arrays["position"], self.motion.internal)
        self._bending_rate = 0.0 if self.surface.bending is None else self.surface.bending.rate

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        super().restore(arrays)
        self.surface.go_on(self.arrays["position"])
        self._find_forces()

    # contact

    def make_contact_surface(self, column: int) -> PointsOfFaces | PointsOfNodes | None:
        """Return the contact surface of the membrane: its nodes as contact points or, if prescribed motions apply to all
        nodes, points within the elements. column: index of the contact work in the works of a step.
        """
        if self.grid is None:
            return None
        self._contact_row = column - FIRST_LOAD
        position, velocity, loads = self.arrays["position"], self.arrays["velocity"], self.motion.loads[self._contact_row]

        def take(force: np.ndarray) -> None:
            loads[...] += force

        grid, cells, places = self.grid, self.surface.cells, (lambda: position, lambda: velocity)
        surface: PointsOfFaces | PointsOfNodes
        if self.follows:
            surface = PointsOfFaces(grid, cells.surface(), *places, take, hard=True)
        else:
            areas, warning = self.surface_areas(), self.contact_warning
            surface = PointsOfNodes(grid, cells, *places, self.vector_areas, areas, take, warning)
            if surface.triangles is not None:
                each = sparse.eye_array(len(position), format="csr")
                surface.triangles = surface.triangles._replace(response=NodalResponse(each, self.motion))
        surface.two_sided, surface.half_width = True, self.surface.contact_reach
        surface.mass_per_area, surface.rate = self.areal_density, self.totals.rate
        self.contact_surface = surface
        return surface

    def contact_warning(self, nodes: np.ndarray) -> str | None:
        """Return a warning if elements in contact at the grid nodes `nodes` are larger than the grid cells; None otherwise."""
        return self.surface.overlong(self.name, self.arrays["position"], self.grid, nodes) if self.grid else None

    # results

    def field(self, name: str) -> np.ndarray:
        if name == "kinetic_energy":
            return self.kinetic_energies()
        if name in OF_NODES:
            return self.arrays[name]
        try:
            return self.surface.field(name, self.arrays["position"], self.arrays["mass"])
        except KeyError:
            raise self.no_field(name) from None
