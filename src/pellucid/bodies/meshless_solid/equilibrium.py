"""Potential energy, forces and stiffness of a meshless solid at trial positions of its nodes, for its equilibria and for its
motion in implicit time steps."""

from collections.abc import Callable

import numpy as np

from pellucid.bodies.meshless_solid.linear_stiffness import ACCURACY, LinearStiffness, LinearTetrahedra
from pellucid.bodies.meshless_solid.material_forces import ElasticForces
from pellucid.bodies.meshless_solid.solid import LEAST_J
from pellucid.bodies.meshless_solid.step_forces import in_rows
from pellucid.bodies.meshless_solid.stiffness import SolidStiffness
from pellucid.bodies.own_nodes.equilibrium import DIFFERENCE, NodalSystem, Strained
from pellucid.bodies.own_nodes.motion import NodalMotion, Tangent
from pellucid.bodies.own_nodes.stiffness import NodalStiffness
from pellucid.parts.elastic_system import Trial


class SolidSystem(NodalSystem):
    """An `ElasticSystem` of a meshless solid whose nodal values are prescribed directly.

    rest, position, motion, stiffness, accepted: as for `NodalSystem`; forces: internal forces of the solid; tetrahedra:
    linear tetrahedra whose stiffness is factored, as an approximation; None: the stiffness of the solid is factored.
    """

    def __init__(
        self,
        rest: np.ndarray,
        position: np.ndarray,
        forces: ElasticForces,
        motion: NodalMotion,
        stiffness: float,
        accepted: Callable[[float], None],
        tetrahedra: LinearTetrahedra | None = None,
    ) -> None:
        self._forces, self._tetrahedra = forces, tetrahedra
        if tetrahedra is not None:
            self.is_approximate, self.settled = True, 10.0 * ACCURACY
        super().__init__(rest, position, motion, stiffness, accepted)

    def _strain(self, position: np.ndarray) -> Strained:
        solid = self._forces.solid
        self._forces.find(position - self.rest, self._motion.internal, 0.0)
        least = solid.sums[:, LEAST_J].min()
        if len(solid.block_volume):
            least = min(least, solid.node_sums[:, LEAST_J].min())
        return Strained(self._stored_energy(), bool(least > 0.0))

    def _stored_energy(self) -> float:
        return self._forces.stored()

    def _new_stiffness(self) -> NodalStiffness:
        if self._tetrahedra is not None:
            return LinearStiffness(self._forces.solid, self._tetrahedra, self._resisted)
        return SolidStiffness(self._forces.solid, self.rest)

    def _resisted(self, displacement: np.ndarray) -> np.ndarray:
        """Return the forces with which the solid resists displacements from the last trial positions [m], by differences [N],
        shape (n, 3) both. Leaves the strains there."""
        size = float(np.abs(displacement).max())
        if size == 0.0:
            return np.zeros_like(displacement)
        step, force = DIFFERENCE * float(np.ptp(self.rest, axis=0).max()) / size, np.empty_like(displacement)
        self._forces.find(self.tried + step * displacement - self.rest, force, 0.0)
        return (self._motion.internal - force) / step

    def _linear(self, force: np.ndarray) -> Tangent:
        found = super()._linear(force)
        if self.is_approximate:
            self._strain(self.tried)
        return found


class MovingSolid(SolidSystem):
    """A `MovingSystem` of a meshless solid, with the arguments of `SolidSystem`."""

    def __init__(
        self,
        rest: np.ndarray,
        position: np.ndarray,
        forces: ElasticForces,
        motion: NodalMotion,
        stiffness: float,
        accepted: Callable[[float], None],
    ) -> None:
        super().__init__(rest, position, forces, motion, stiffness, accepted)
        self.added: np.ndarray | None = None
        self._sudden = 0.0  # time in which viscous stresses relax in the stiffness [s]
        self.velocity, self.drag = motion.velocity, 0.0
        self._in_step = forces.in_step()
        self.keeps_factors = not forces.arrays

    @property
    def inertia(self) -> np.ndarray:
        return self._motion.inertia

    @property
    def free(self) -> np.ndarray:
        return self._motion.free

    def begin(self, dt: float) -> None:
        super().begin(dt)
        self.drag = self._motion.drag_rate(dt)
        self._in_step.begin(dt)
        self._sudden = 0.5 * dt

    def attempt_step(self, middle: np.ndarray) -> Trial:
        internal, external = self._motion.internal, self._external
        if self._follow:
            self._present[:] = middle
            self._renew(0.5)
            external[:] = self._motion.forces() - internal
        is_sound = self._in_step.find(self.position + self._moved(middle) - self.rest, internal)
        residual = np.where(self.free, internal + external, 0.0)
        size = float(np.sqrt(np.sum(internal * internal)) + np.sqrt(np.sum(external * external)))
        return Trial(0.0, residual, size, is_sound and bool(np.isfinite(size)))

    def factor(self) -> None:
        self.in_single = self._matrix().renew(self.free, self._present, self.in_single, self.added, self._sudden)

    def factor_at(self, position: np.ndarray) -> None:
        self._forces.find(position - self.rest, np.empty_like(position), 0.0)
        self.factor()

    def arrive(self, middle: np.ndarray, dt: float) -> None:
        moved = self._moved(middle)
        self._motion.record_step(moved, self._rates, self.drag, dt)
        self._present[:] = self.position + moved
        displacement = self._present - self.rest
        if self._forces.arrays:
            self._forces.find(displacement, self._motion.internal, 0.0)
            self._in_step.advance_states(displacement, in_rows(self._forces.solid.deformation))
        self._accepted(dt)

    def _moved(self, middle: np.ndarray) -> np.ndarray:
        """Return the displacements in a step with these positions in its middle [m], shape (n, 3)."""
        return np.where(self.free, 2.0 * (middle - self.position), self.increment)
