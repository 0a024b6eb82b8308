"""The internal forces of a meshless solid with a hyperelastic law, or a law that has history variables; their energy, and the
largest frequency, which limits the time step.

With history variables, forces are computed as in `pellucid.bodies.meshless_solid.forces`, except that the stress of a point is
the stress of its state. The state is advanced over a time dt with the velocity gradient that maps its deformation gradient F₀
to the present one, L = (F F₀⁻¹ - I)/dt: P = J σ F⁻ᵀ. If the volume ratio is averaged, this applies to the volumetric part of
the underlying hyperelastic law; the viscous part has none.
"""

from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np

from pellucid.bodies.meshless_solid.forces import find_stresses, gradient_at, in_kernels, internal_forces, keep_stress
from pellucid.bodies.meshless_solid.nodal_fields import AtPoints, elastic_points, prestressed, with_prestress
from pellucid.bodies.meshless_solid.solid import COLUMN, ENERGY, LOST, PACKS, WEIGHT, Solid, deformation_gradients
from pellucid.bodies.meshless_solid.stable_step import ITERATIONS, PowerIteration, converge
from pellucid.bodies.meshless_solid.step_forces import StepForces
from pellucid.jit import kernel, point_function
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES
from pellucid.materials.law import ZERO_GRADIENT, Law, diffusivity, dissipated_energy, signal_speed, stored_energy, update
from pellucid.materials.point_state import PointState, in_arrays, initial_arrays, load, store
from pellucid.tensors import cofactor, determinant, multiply, piola_transform


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

    def in_step(self) -> StepForces:
        """Return the forces in time steps that conserve energy."""
        return StepForces(self.solid, self.bundle, None, {})

    def _of_law(self, n: int) -> AtPoints:
        return elastic_points(self.solid, n)


SUDDEN = 1e-6  # duration of a trial displacement without relaxation, times the largest frequency
RETOLD = 3  # power iterations between updates of the frequency for materials that diffuse momentum


class Viscous(NamedTuple):
    """A material law with history variables (viscous stresses), and the initial state of its points."""

    law: Law  # law with history variables
    state: PointState  # initial stress and history variables


class History(NamedTuple):
    """The law with history variables and the states of its points; the solid itself stores only the hyperelastic law."""

    law: Any  # law with history variables
    states: Any  # states of the points, in arrays; lanes without a point are at the end
    density: float  # initial density [kg/m³]


@kernel(inner=True)
def _velocity_gradient(F, F0, dt):
    C, over = cofactor(F0), 1.0 / determinant(F0)
    inverse = (C[0], C[3], C[6], C[1], C[4], C[7], C[2], C[5], C[8])
    f, rate = multiply(F, inverse), 1.0 / dt
    return (
        rate * (over * f[0] - 1.0),
        rate * (over * f[1]),
        rate * (over * f[2]),
        rate * (over * f[3]),
        rate * (over * f[4] - 1.0),
        rate * (over * f[5]),
        rate * (over * f[6]),
        rate * (over * f[7]),
        rate * (over * f[8] - 1.0),
    )


@point_function(find_stresses, History)
def _find_stresses(points, first, n, solid, dt, keep, averaged, s):
    lost = 0.0
    for i in range(n * LANES):
        p = LANES * first + i
        F = gradient_at(s, i)
        w, J = s[WEIGHT * COLUMN + i], determinant(F)
        density, state = points.density / J, load(points.states, p)
        if dt > 0.0:
            state = update(points.law, state, density, _velocity_gradient(F, state.deformation_gradient, dt), dt, 0.0)
            if keep:
                store(points.states, p, state)
                for k in range(9):  # not as the law rounds it
                    points.states.deformation_gradient[p, k] = F[k]
                state = load(points.states, p)
        stored = points.density * stored_energy(points.law, state, density)
        lost += w * points.density * dissipated_energy(points.law, state, density)
        keep_stress(s, i, solid.law, averaged, F, J, stored, piola_transform(state.stress, F))
    return lost


@parallel_loop()
def _energies(block, history, stored, lost):
    for p in range(LANES * PACKS * block, min(LANES * PACKS * (block + 1), len(stored))):
        state = load(history.states, p)
        density = history.density / determinant(state.deformation_gradient)
        stored[p] = history.density * stored_energy(history.law, state, density)
        lost[p] = history.density * dissipated_energy(history.law, state, density)


class ViscousForces(ElasticForces):
    """Internal forces of a material law with history variables, which this class stores."""

    def __init__(
        self, viscous: Viscous, solid: Solid, density: float, wave_number: float, initial_stress: np.ndarray | None = None
    ) -> None:
        """viscous: law and initial state; solid: data of the solid for kernels; density: initial density [kg/m³]; wave_number:
        largest wave number of waves in the solid [1/m], or an upper bound; initial_stress: of the points [Pa], shape (n, 6).
        """
        law, state = viscous
        arrays = initial_arrays(state, len(solid.weights))
        history = History(law, in_arrays(state, arrays), density)
        super().__init__(solid._replace(points=history), initial_stress)
        self._plain, self._initial_stress = solid, initial_stress
        self.arrays, self._history = arrays, Bundle(history)
        self._bound = wave_number * signal_speed(law, state, density, ZERO_GRADIENT, 0.0)
        self._diffuses = diffusivity(law, density) > 0.0  # the stiffness grows without limit with the strain rate

    def find(self, displacement: np.ndarray, force: np.ndarray, dt: float) -> None:
        """Compute the internal forces `force` [N] at nodal displacements [m], shape (n, 3) both, reached in a step dt [s], and
        advance the history variables. A step with dt = 0 does not change states or forces.
        """
        self._find(displacement, force, dt, True)

    def _try(self, displacement: np.ndarray, force: np.ndarray, frequency: float) -> None:
        self._find(displacement, force, (1.0 if self._diffuses else SUDDEN) / frequency, False)

    def in_step(self) -> StepForces:
        elastic = prestressed(self._plain, self._initial_stress)
        return StepForces(self.solid, in_kernels(elastic), self.bundle, self.arrays)

    @property
    def lost(self) -> float:
        return float(self.solid.sums[:, LOST].sum())

    def converge(self, iteration: PowerIteration, displacement: np.ndarray) -> None:
        """Estimate the largest natural frequency by power iteration around nodal displacements [m], shape (n, 3); `iteration`
        stores it. The stiffness includes viscous forces and the viscoelastic branches of the law that have not relaxed.
        """
        converge(iteration, self._try, displacement, self._bound, RETOLD if self._diffuses else ITERATIONS)

    def find_and_iterate(self, displacement: np.ndarray, force: np.ndarray, dt: float, iteration: PowerIteration) -> None:
        """Compute the internal forces `force` [N] at nodal displacements [m], shape (n, 3) both, reached in a step dt [s],
        advance the history variables, and perform one power iteration towards the largest natural frequency, which `iteration`
        stores. All forces of the iteration start from the material states at the end of the step.
        """
        self.find(displacement, force, dt)
        here, there = np.empty_like(force), np.empty_like(force)
        told = iteration.frequency or self._bound
        self._try(displacement, here, told)
        self._try(displacement + iteration.trial(), there, told)
        iteration.learn(here - there)
        self.find(displacement, force, 0.0)  # its sums are those of the last call

    def _of_law(self, n: int) -> AtPoints:
        stored, lost = np.zeros(n), np.zeros(n)
        _energies(len(self.solid.sums), self._history, stored, lost)
        return AtPoints(self.arrays["stress"][:n], stored, lost)
