"""Nodal arrays set to zero by all threads: on a large grid with small bodies that is much of a step."""

import numpy as np

from pellucid.grid.lattice import Nodes
from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for

CHUNK = 1024  # nodes that a thread takes at a time


@kernel(inner=True)
def _clear_chunk(chunk, inertia, forces, apart):
    for k in range(4 * CHUNK * chunk, min(4 * CHUNK * (chunk + 1), len(inertia))):
        inertia[k] = forces[k] = 0.0
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(apart))):
        apart[I, 0] = apart[I, 1] = apart[I, 2] = 0.0


@kernel()
def _clear(chunks, inertia, forces, apart):
    parallel_for(_clear_chunk, chunks, inertia, forces, apart)


@kernel(inner=True)
def _clear_momentum_chunk(chunk, momentum):
    for I in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(momentum))):
        momentum[I, 0] = momentum[I, 1] = momentum[I, 2] = 0.0


@kernel()
def _clear_momentum(chunks, momentum):
    parallel_for(_clear_momentum_chunk, chunks, momentum)


def clear(nodes: Nodes, apart: np.ndarray) -> None:
    """Set mass, momentum and internal forces to zero, and those that are kept apart, shape (n, 4) or (0, 4)."""
    _clear(_chunks(nodes), nodes.inertia, nodes.forces, apart)


def clear_momentum(nodes: Nodes) -> None:
    """Set the momentum to zero."""
    _clear_momentum(_chunks(nodes), nodes.momentum)


def _chunks(nodes: Nodes) -> int:
    return -(-len(nodes.mass) // CHUNK)
