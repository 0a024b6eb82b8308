"""The largest frequency of a solid about its present state, by power iteration: it bounds the step of central differences."""

from collections.abc import Callable

import numpy as np

ITERATIONS = 30
SMALL = 1e-7  # of the extent of the solid: the displacement with which forces are differenced

Forces = Callable[[np.ndarray, np.ndarray, float], None]
"""Fills internal forces [N] at displacements [m], both of shape (n, 3), that are reached in the time of a frequency [rad/s]."""


def largest_frequency(
    forces: Forces,
    displacement: np.ndarray,
    mass: np.ndarray,
    free: np.ndarray,
    extent: float,
    start: float = 0.0,
    renewed: int = ITERATIONS,
) -> float:
    """The largest angular frequency [rad/s] of nodes with a mass [kg], shape (n,), that move where `free`, shape (n, 3).

    extent: of the solid [m]; start: what forces are told of the frequency at first; renewed: the iterations after which they
    are told what was found. The iteration starts from the same vector every time, so that a run that goes on from a checkpoint
    finds the same bound.

    Viscous forces: central differences with C by the velocity of half a step before, M a = -K u - C v, are stable for
    4 M - dt² K - 2 dt C ≥ 0. With s = 2/dt the bound is where s² is the largest eigenvalue of M⁻¹ (K + s C): the stiffness in a
    displacement that takes the time 1/s. So it is found with the vector; an error in s is halved, at least, each time.
    For one mode of damping ratio ξ it is dt = 2/ω (√(1 + ξ²) - ξ).
    """
    mass = mass[:, None]
    vector = np.random.default_rng(0).standard_normal(displacement.shape) * free / np.sqrt(mass)
    here, there = np.empty_like(displacement), np.empty_like(displacement)
    square, told = 0.0, start
    for iteration in range(ITERATIONS):
        if iteration % renewed == 0:
            told = float(np.sqrt(square)) if iteration > 0 and square > 0.0 else told
            forces(displacement, here, told)
        size = float(np.sqrt(np.sum(mass * vector * vector)))
        if size == 0.0:
            return 0.0
        vector = vector / size
        scale = SMALL * extent / float(abs(vector).max())
        forces(displacement + scale * vector, there, told)
        pull = free * (here - there) / scale
        square = float(np.sum(vector * pull))
        vector = pull / mass
    return float(np.sqrt(max(square, 0.0)))
