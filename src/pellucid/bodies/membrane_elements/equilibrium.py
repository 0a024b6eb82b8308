"""Potential energy, forces and stiffness of a membrane of triangles at trial positions of its nodes, for its equilibria."""

from collections.abc import Callable

import numpy as np
from scipy import sparse

from pellucid.bodies.membrane_elements.surface import ElementSurface
from pellucid.bodies.own_nodes.equilibrium import NodalSystem, Strained
from pellucid.bodies.own_nodes.motion import NodalMotion
from pellucid.bodies.own_nodes.stiffness import NodalStiffness
from pellucid.energy import Totals
from pellucid.linear.differences import GroupedDifferences

STEP = 1e-5  # difference of a coordinate over the shortest edge: errors of 1e-10 by curvature, 1e-11 by rounding


class MembraneSystem(NodalSystem):
    """An `ElasticSystem` of a membrane of triangles with its own nodes.

    surface: elements of the membrane; position, motion, stiffness, accepted: as for `NodalSystem`; totals: energies of the
    body, which are set with the strains; conserves: True if the stress is the derivative of an energy.
    """

    includes_load_stiffness = True

    def __init__(
        self,
        surface: ElementSurface,
        position: np.ndarray,
        motion: NodalMotion,
        stiffness: float,
        accepted: Callable[[float], None],
        totals: Totals,
        conserves: bool,
    ) -> None:
        self._surface, self._totals, self.has_energy = surface, totals, conserves
        self._bent = surface.supports_of_bending
        super().__init__(surface.vertices, position, motion, stiffness, accepted)

    def begin(self, dt: float) -> None:
        super().begin(dt)
        if self._bent is not self._surface.supports_of_bending:  # other nodes are linked
            self._bent, self._stiffness = self._surface.supports_of_bending, None

    def _strain(self, position: np.ndarray) -> Strained:
        self._surface.take_state(position, self._totals)
        self._motion.internal.fill(0.0)
        self._surface.add_internal_forces(position, self._motion.internal)
        return Strained(self._totals.stored, self._surface.fault() is None)

    def _stored_energy(self) -> float:
        return self._totals.stored

    def _new_stiffness(self) -> "MembraneStiffness":
        return MembraneStiffness(self._surface, self)

    def local_forces(self, position: np.ndarray) -> np.ndarray:
        """Return internal forces and loads that follow the nodes, for nodes at these positions, without the forces of penalties
        on the whole membrane [N], shape (n, 3)."""
        if self._follow:
            self._present[:] = position
            self._renew(self._share)
        self._surface.strain(position, np.zeros_like(position), 0.0, Totals())
        self._motion.internal.fill(0.0)
        self._surface.add_local_forces(position, self._motion.internal)
        # loads that do not follow have no differences, and rounding with those of another load step would leave a trace
        return self._motion.forces() if self._follow else self._motion.internal

    def restore_trial(self) -> None:
        """Return to the last trial positions after forces were computed elsewhere."""
        self.attempt(self.tried)


class MembraneStiffness(NodalStiffness):
    """Stiffness of a membrane of triangles with its loads, and solutions of linear systems with it.

    surface: elements of the membrane; system: its forces.
    """

    least_pivot = 10.0 * STEP**2  # across a flat membrane the differences of forces are those of their curvature

    def __init__(self, surface: ElementSurface, system: MembraneSystem) -> None:
        self._surface, self._system = surface, system
        terms = surface.linked_nodes()
        links = sparse.csr_array(terms.T @ terms)
        super().__init__(links, surface.vertices)
        self._differences = GroupedDifferences(links, STEP * surface.shortest_edge())

    def _find(self, dt: float) -> None:
        position, kept = self._system.tried.copy(), self._surface.constraints
        tension, suction = (0.0, 0.0) if kept is None else kept.tensions(self._surface, position)

        def forces(x: np.ndarray) -> np.ndarray:
            found = self._system.local_forces(x)
            if kept is None:
                return found
            growth, outwards = self._surface.slopes(x)
            return np.asarray(found - tension * growth - suction * outwards)

        self._values[self._entry] = self._differences.find(forces, position)
        self._system.restore_trial()

    def _springs(self) -> list[tuple[float, np.ndarray]]:
        kept = self._surface.constraints
        return [] if kept is None else kept.springs(self._surface, self._system.tried)
