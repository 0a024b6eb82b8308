"""The power of forces on the nodes of a body, summed in a fixed order."""

import numpy as np

from pellucid.jit.loops import parallel_loop
from pellucid.reductions import ordered_sum

CHUNK = 4096  # nodes


@parallel_loop()
def _sum(chunk, force, velocity, sums):
    total = 0.0
    for p in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(force))):
        for d in range(3):
            total += force[p, d] * velocity[p, d]
    sums[chunk, 0] = total


def power(force: np.ndarray, velocity: np.ndarray) -> float:
    """Return the power Σ f·v [W] of forces [N] and velocities [m/s], both of shape (n, 3)."""
    chunks = (len(force) + CHUNK - 1) // CHUNK
    sums = np.zeros((chunks, 1))
    _sum(chunks, force, velocity, sums)
    return float(ordered_sum(sums)[0])
