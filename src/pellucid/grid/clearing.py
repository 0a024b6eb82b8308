"""Nodal arrays set to zero by all threads: on a large grid with small bodies that is much of a step."""

from pellucid.grid.listed import CHUNK, end_of, listed
from pellucid.grid.momentum import is_zero
from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for
from pellucid.jit.vector import splat, store


@kernel(inner=True)
def _clear_chunk(chunk, nodes, apart, node):
    zero = splat(0.0)
    for e in range(CHUNK * chunk, end_of(chunk, node, nodes.mass)):
        I = listed(node, e)
        if nodes.mass[I] != 0.0 or not is_zero(nodes.force, I):  # what is read alone need not go back to memory
            store(nodes.inertia, 4 * I, zero)
            store(nodes.forces, 4 * I, zero)
        if len(apart) > 0:
            apart[I, 0] = apart[I, 1] = apart[I, 2] = 0.0


@kernel()
def clear(chunks, nodes, apart, node):
    """Set mass, momentum and internal forces of listed nodes to zero, and those that are kept apart, shape (n, 4) or (0, 4).

    nodes: a bundle of `Nodes`.
    """
    parallel_for(_clear_chunk, chunks, nodes, apart, node)


@kernel(inner=True)
def _clear_momentum_chunk(chunk, nodes, node):
    for e in range(CHUNK * chunk, end_of(chunk, node, nodes.mass)):
        I = listed(node, e)
        nodes.momentum[I, 0] = nodes.momentum[I, 1] = nodes.momentum[I, 2] = 0.0


@kernel()
def clear_momentum(chunks, nodes, node):
    """Set the momentum of listed nodes to zero."""
    parallel_for(_clear_momentum_chunk, chunks, nodes, node)
