"""Internal forces of a meshless solid under a law whose points have a history.

As in `forces`, but the stress of a point is that of its state, which goes on with the velocity gradient that takes the
deformation gradient of the state, F₀, to the present one in a time dt, L = (F F₀⁻¹ - I)/dt: P = J σ F⁻ᵀ. Where the volume
ratio is averaged, it is the volumetric part of the hyperelastic law inside that is; what is viscous has none.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.bodies.meshless_solid.forces import (
    BATCH,
    COLUMN,
    COLUMNS,
    NODAL,
    PACKS,
    RATIO,
    STORED,
    STRESS,
    WEIGHT,
    Solid,
    add_blocks,
    average_chunk,
    deform_block,
    displacements,
    end_block,
    fill_batch,
    mean_stresses,
    pull,
)
from pellucid.bodies.meshless_solid.nodal_fields import AtPoints
from pellucid.bodies.meshless_solid.solid_forces import ElasticForces
from pellucid.bodies.meshless_solid.stable_step import ITERATIONS, PowerIteration, converge
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.parallel import parallel_for
from pellucid.jit.vector import LANES, splat
from pellucid.jit.vector import load as load_lanes
from pellucid.materials.law import (
    AT_REST,
    Law,
    diffusivity,
    dissipated_energy,
    signal_speed,
    stored_energy,
    update,
    volumetric_energy,
    volumetric_stress,
)
from pellucid.materials.point_state import PointState, in_arrays, initial_arrays, load, store
from pellucid.tensors import cofactor, determinant, multiply, piola_transform

SUDDEN = 1e-6  # of the time of the fastest mode: nothing relaxes in it
RETOLD = 3  # power iterations after which forces that diffuse are told the frequency anew


class Viscous(NamedTuple):
    """A law with a history, and the state of its points at the start."""

    law: Law
    state: PointState


class History(NamedTuple):
    """What kernels take beside the solid, whose own law is the hyperelastic one."""

    law: Any
    states: Any  # of the points, in arrays; those of the lanes without a point stand at their end
    density: float  # at the start [kg/m³]
    lost: np.ndarray  # (blocks,) dissipated so far [J]


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


@kernel(inner=True)
def _find_stresses(first, n, solid, history, dt, keep, averaged, s):
    """As in `forces`, of n packs; the energy [J] that their points lost so far. Where `keep`, the states go on."""
    lost = 0.0
    for i in range(n * LANES):
        p = LANES * first + i
        F = (
            s[i],
            s[COLUMN + i],
            s[2 * COLUMN + i],
            s[3 * COLUMN + i],
            s[4 * COLUMN + i],
            s[5 * COLUMN + i],
            s[6 * COLUMN + i],
            s[7 * COLUMN + i],
            s[8 * COLUMN + i],
        )
        w, J = s[WEIGHT * COLUMN + i], determinant(F)
        density, state = history.density / J, load(history.states, p)
        if dt > 0.0:
            state = update(history.law, state, density, _velocity_gradient(F, state.deformation_gradient, dt), dt, 0.0)
            if keep:
                store(history.states, p, state)
                for k in range(9):  # not as the law rounds it
                    history.states.deformation_gradient[p, k] = F[k]
                state = load(history.states, p)
        P, extra = piola_transform(state.stress, F), 0.0
        stored = history.density * stored_energy(history.law, state, density)
        lost += w * history.density * dissipated_energy(history.law, state, density)
        if averaged:
            stored -= volumetric_energy(solid.law, J)
            extra = s[NODAL * COLUMN + i] - w * volumetric_stress(solid.law, J)
        C = cofactor(F)
        for k in range(9):
            s[(STRESS + k) * COLUMN + i] = w * P[k] + extra * C[k]
        s[STORED * COLUMN + i] = w * stored
        s[RATIO * COLUMN + i] = J
    return lost


@kernel(inner=True)
def _force_block(block, solid, history, dt, keep):
    blocks, averaged = solid.blocks, len(solid.block_volume) > 0
    start, m = blocks.first[block], blocks.first[block + 1] - blocks.first[block]
    u = displacements(start, m, solid)
    f, mean, s = np.zeros(LANES * m), mean_stresses(start, m, solid), np.zeros(COLUMNS * COLUMN)
    stored, least, lost = splat(0.0), np.inf, 0.0
    end = min(PACKS * (block + 1), len(solid.corners.first) - 1)
    for first in range(PACKS * block, end, BATCH):
        n = min(BATCH, end - first)
        fill_batch(first, n, solid, averaged, mean, u, s)
        lost += _find_stresses(first, n, solid, history, dt, keep, averaged, s)
        for k in range(n):
            pull(first + k, solid, s, STRESS * COLUMN + k * LANES, f)
            stored += load_lanes(s, STORED * COLUMN + k * LANES)
            for lane in range(LANES):
                least = min(least, s[RATIO * COLUMN + k * LANES + lane])
    end_block(block, solid, f, stored, least)
    history.lost[block] = lost


@kernel()
def _viscous_forces(n_blocks, chunks, solid, history, dt, keep, force):
    if len(solid.block_volume) > 0:
        parallel_for(deform_block, n_blocks, solid)
        parallel_for(average_chunk, chunks, solid)
    parallel_for(_force_block, n_blocks, solid, history, dt, keep)
    parallel_for(add_blocks, chunks, solid, force)


@kernel(inner=True)
def _energies_block(block, history, stored, lost):
    for p in range(LANES * PACKS * block, min(LANES * PACKS * (block + 1), len(stored))):
        state = load(history.states, p)
        density = history.density / determinant(state.deformation_gradient)
        stored[p] = history.density * stored_energy(history.law, state, density)
        lost[p] = history.density * dissipated_energy(history.law, state, density)


@kernel()
def _energies(n_blocks, history, stored, lost):
    parallel_for(_energies_block, n_blocks, history, stored, lost)


class ViscousForces(ElasticForces):
    """Those of a law whose points have a history, which is kept here."""

    def __init__(self, viscous: Viscous, solid: Solid, density: float, wave_number: float) -> None:
        """wave_number: the largest [1/m] that waves in the solid can have, or a bound above it."""
        super().__init__(solid)
        law, state = viscous
        self.arrays = initial_arrays(state, len(solid.weights))
        states = in_arrays(state, self.arrays)
        self._history = History(law, states, density, np.zeros(len(solid.sums)))
        self._points = Bundle(self._history)
        self._bound = wave_number * signal_speed(law, state, density, AT_REST, 0.0)
        self._diffuses = diffusivity(law, density) > 0.0  # faster strain is stiffer without end

    def find(self, displacement: np.ndarray, force: np.ndarray, dt: float) -> None:
        """As of what is hyperelastic; the states go on. A step without time leaves them and the forces as they are."""
        self._find(displacement, force, dt, True)

    def _find(self, displacement: np.ndarray, force: np.ndarray, dt: float, keep: bool) -> None:
        solid = self.solid
        solid.displacement[:] = displacement
        _viscous_forces(len(solid.sums), len(solid.node_sums), self.bundle, self._points, dt, keep, force)

    def _try(self, displacement: np.ndarray, force: np.ndarray, frequency: float) -> None:
        self._find(displacement, force, (1.0 if self._diffuses else SUDDEN) / frequency, False)

    @property
    def lost(self) -> float:
        """Dissipated so far [J]."""
        return float(self._history.lost.sum())

    def converge(self, iteration: PowerIteration, displacement: np.ndarray) -> None:
        """As the function, of viscous forces, and of those that fade as long as they have not."""
        converge(iteration, self._try, displacement, self._bound, RETOLD if self._diffuses else ITERATIONS)

    def find_and_iterate(self, displacement: np.ndarray, force: np.ndarray, dt: float, iteration: PowerIteration) -> None:
        """As of what is hyperelastic, with both trials from the states at the end of the step."""
        self.find(displacement, force, dt)
        here, there = np.empty_like(force), np.empty_like(force)
        told = iteration.frequency or self._bound
        self._try(displacement, here, told)
        self._try(displacement + iteration.trial(), there, told)
        iteration.learn(here - there)
        self.find(displacement, force, 0.0)  # its sums are those of the last call

    def at_points(self, n: int) -> AtPoints:
        """Stresses and energies at the n points."""
        stored, lost = np.zeros(n), np.zeros(n)
        _energies(len(self.solid.sums), self._points, stored, lost)
        return AtPoints(self.arrays["stress"][:n], stored, lost)
