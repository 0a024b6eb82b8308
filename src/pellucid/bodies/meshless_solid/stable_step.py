"""The largest frequency of a solid about its present state, by power iteration: it bounds the step of central differences."""

from collections.abc import Callable

import numpy as np

ITERATIONS = 30
SMALL = 1e-7  # of the extent of the solid: the displacement with which forces are differenced

Forces = Callable[[np.ndarray, np.ndarray], None]
"""Fills internal forces [N] at displacements [m], both of shape (n, 3)."""


def largest_frequency(forces: Forces, displacement: np.ndarray, mass: np.ndarray, free: np.ndarray, extent: float) -> float:
    """The largest angular frequency [rad/s] of nodes with a mass [kg], shape (n,), that move where `free`, shape (n, 3).

    extent: of the solid [m]. The iteration starts from the same vector every time, so that a run that goes on from a checkpoint
    finds the same bound.
    """
    mass = mass[:, None]
    vector = np.random.default_rng(0).standard_normal(displacement.shape) * free / np.sqrt(mass)
    here, there = np.empty_like(displacement), np.empty_like(displacement)
    forces(displacement, here)
    square = 0.0
    for _ in range(ITERATIONS):
        size = float(np.sqrt(np.sum(mass * vector * vector)))
        if size == 0.0:
            return 0.0
        vector = vector / size
        scale = SMALL * extent / float(abs(vector).max())
        forces(displacement + scale * vector, there)
        pull = free * (here - there) / scale
        square = float(np.sum(vector * pull))
        vector = pull / mass
    return float(np.sqrt(max(square, 0.0)))
