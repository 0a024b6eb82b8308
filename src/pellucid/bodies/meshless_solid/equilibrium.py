"""Potential energy, forces and stiffness of a meshless solid at trial positions of its nodes, for its equilibria and for its
motion in implicit time steps."""

from collections.abc import Callable

import numpy as np

from pellucid.bodies.meshless_solid.material_forces import ElasticForces
from pellucid.bodies.meshless_solid.solid import LEAST_J
from pellucid.bodies.meshless_solid.step_forces import in_rows
from pellucid.bodies.meshless_solid.stiffness import SolidStiffness, is_held
from pellucid.bodies.own_nodes.motion import Moved, NodalMotion, Tangent
from pellucid.parts.elastic_system import Trial

ROUNDING = 1e-15  # of the energy over modulus and volume: laws subtract numbers of size 1


class SolidSystem:
    """An `ElasticSystem` of a meshless solid whose nodal values are prescribed directly.

    rest, position: nodal positions at rest and at present [m], shape (n, 3); forces: internal forces of the solid; motion:
    equation of motion of its nodes; stiffness: modulus times volume of the solid [J]; accepted: function of the body that is
    called after a new equilibrium, with the step of the time of the loads [s], or at the end of a time step [s].
    """

    def __init__(
        self,
        rest: np.ndarray,
        position: np.ndarray,
        forces: ElasticForces,
        motion: NodalMotion,
        stiffness: float,
        accepted: Callable[[float], None],
    ) -> None:
        self.rest, self._present, self._forces, self._motion, self._accepted = rest, position, forces, motion, accepted
        self.added: np.ndarray | None = None
        self._sudden = 0.0  # time in which displacements resist as the stiffness says [s], for materials with history variables
        self.rounding, self.in_single = ROUNDING * stiffness, True
        self.position, self.increment = position.copy(), np.zeros_like(rest)
        self._external, self.has_potential = np.zeros_like(rest), True
        self._renew: Callable[[], None] | None = None
        self._before, self._rates = motion.force_parts(), motion.prescribed_rates()
        self._leaving = Tangent(self.increment, self.increment)
        self._free, self._stored = motion.free, forces.stored()  # at the last equilibrium
        self._stiffness: SolidStiffness | None = None

    def begin(self, dt: float) -> None:
        self.position[:] = self._present
        self._stored = self._forces.stored()
        self._before, self._rates = self._motion.force_parts(), self._motion.prescribed_rates()
        self.increment[:] = dt * self._motion.at_nodes(self._rates)

    def take_loads(self, renew: Callable[[], None] | None) -> None:
        self._renew, self.has_potential = renew, renew is None
        self._external[:] = self._motion.forces() - self._motion.internal

    def attempt(self, position: np.ndarray) -> Trial:
        internal, solid, displacement = self._motion.internal, self._forces.solid, position - self.rest
        if self._renew is not None:
            self._present[:] = position
            self._renew()
            self._external[:] = self._motion.forces() - internal
        self._forces.find(displacement, internal, 0.0)
        least = solid.sums[:, LEAST_J].min()
        if len(solid.block_volume):
            least = min(least, solid.node_sums[:, LEAST_J].min())
        energy = self._forces.stored()
        if self.has_potential:
            energy -= float(np.sum(self._external * displacement))
        residual = np.where(self._motion.free, internal + self._external, 0.0)
        size = float(np.sqrt(np.sum(internal * internal)) + np.sqrt(np.sum(self._external * self._external)))
        return Trial(energy, residual, size, bool(least > 0.0) and np.isfinite(energy) and np.isfinite(size))

    @property
    def shift(self) -> float:
        return self._matrix().shift

    def factor(self) -> None:
        free = self._motion.free
        moves = self.added is None and not is_held(self.rest, free)
        self.in_single = self._matrix().renew(free, moves, self.in_single, self.added, self._sudden)

    def solve(self, force: np.ndarray) -> np.ndarray:
        return self._matrix().solve(force)

    def follow(self, force: np.ndarray) -> np.ndarray:
        self._leaving = Tangent(*self._matrix().follow(force, self.increment))
        return self._leaving.moved

    def accept(self, position: np.ndarray, dt: float, jumped: bool) -> None:
        arriving = self._leaving
        if self.has_potential:  # otherwise the stiffness of the loads would be missing in both
            grown = self._external - self._motion.external_forces(self._before)
            arriving = Tangent(*self._matrix().follow(grown, self.increment))
        self._present[:] = position
        moved = Moved(position - self.position, self._leaving, arriving, self._rates)
        self._motion.record_equilibrium(moved, self._before, dt)
        if jumped or (self._motion.free != self._free).any():
            self._motion.lose_rest(self._forces.stored() - self._stored)
        self._free = self._motion.free
        self._accepted(dt)

    def reject(self) -> None:
        self._present[:] = self.position
        self._forces.find(self.position - self.rest, self._motion.internal, 0.0)

    def _matrix(self) -> SolidStiffness:
        if self._stiffness is None:
            self._stiffness = SolidStiffness(self._forces.solid, self.rest)
        return self._stiffness


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
        if self._renew is not None:
            self._present[:] = middle
            self._renew()
            external[:] = self._motion.forces() - internal
        is_sound = self._in_step.find(self.position + self._moved(middle) - self.rest, internal)
        residual = np.where(self.free, internal + external, 0.0)
        size = float(np.sqrt(np.sum(internal * internal)) + np.sqrt(np.sum(external * external)))
        return Trial(0.0, residual, size, is_sound and bool(np.isfinite(size)))

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
