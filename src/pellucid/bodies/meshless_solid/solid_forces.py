"""The internal forces of a hyperelastic meshless solid, their energy, and the largest frequency, which limits the time step."""

from collections.abc import Mapping

import numpy as np

from pellucid.bodies.meshless_solid.forces import in_kernels, internal_forces
from pellucid.bodies.meshless_solid.nodal_fields import AtPoints, elastic_points
from pellucid.bodies.meshless_solid.prestress import prestressed, with_prestress
from pellucid.bodies.meshless_solid.solid import ENERGY, Solid, deformation_gradients
from pellucid.bodies.meshless_solid.stable_step import PowerIteration, converge


class ElasticForces:
    """Internal forces of an elastic material: stresses depend on the deformation only."""

    def __init__(self, solid: Solid, initial_stress: np.ndarray | None = None) -> None:
        """solid: data of the solid for kernels; initial_stress: initial stress of the points [Pa], shape (n, 6); None for
        none.
        """
        self.solid = prestressed(solid, initial_stress)
        self.bundle = in_kernels(self.solid)
        self.arrays: Mapping[str, np.ndarray] = {}
        """History variables of the points, by name."""

    def find(self, displacement: np.ndarray, force: np.ndarray, dt: float) -> None:
        """Compute the internal forces `force` [N], shape (n, 3), at nodal displacements [m], shape (n, 3), reached in a step
        dt [s].
        """
        self._find(displacement, force, dt, False)

    def _find(self, displacement: np.ndarray, force: np.ndarray, dt: float, keep: bool) -> None:
        solid = self.solid
        solid.displacement[:] = displacement
        internal_forces(len(solid.sums), len(solid.node_sums), self.bundle, dt, keep, force)

    def _try(self, displacement: np.ndarray, force: np.ndarray, frequency: float) -> None:
        """Compute the internal forces `force` [N] at trial displacements [m], shape (n, 3) both, that are reached within the
        time 1/frequency [s]. Hyperelastic forces do not depend on this time.
        """
        self.find(displacement, force, 0.0)

    def stored(self) -> float:
        """Return the strain energy of the solid [J]."""
        nodal = float(self.solid.node_sums[:, ENERGY].sum()) if len(self.solid.block_volume) else 0.0
        return float(self.solid.sums[:, ENERGY].sum()) + nodal

    @property
    def lost(self) -> float | None:
        """Energy dissipated so far by the material [J]; None for materials that do not compute it."""
        return None

    def converge(self, iteration: PowerIteration, displacement: np.ndarray) -> None:
        """Estimate the largest natural frequency by power iteration around nodal displacements [m], shape (n, 3); `iteration`
        stores it. Forces and energy must be computed again afterwards.
        """
        converge(iteration, self._try, displacement)

    def find_and_iterate(self, displacement: np.ndarray, force: np.ndarray, dt: float, iteration: PowerIteration) -> None:
        """Compute the internal forces `force` [N] at nodal displacements [m], shape (n, 3) both, reached in a step dt [s], and
        perform one more power iteration towards the largest natural frequency, which `iteration` stores.
        """
        there = np.empty_like(force)
        self._try(displacement + iteration.trial(), there, iteration.frequency)
        self.find(displacement, force, dt)
        iteration.learn(force - there)

    def at_points(self, n: int) -> AtPoints:
        """Return the Cauchy stresses and energies at the n quadrature points, with the contributions of the initial stress."""
        return with_prestress(
            self._of_law(n), self.solid, deformation_gradients(self.solid, n // self.solid.n_points).reshape(n, 3, 3)
        )

    def _of_law(self, n: int) -> AtPoints:
        return elastic_points(self.solid, n)
