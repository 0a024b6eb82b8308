"""Vectors between points and nodes: forces and other vectors that points have, to the nodes; nodal vectors to the points."""

import numpy as np
from numpy import uintp

from pellucid.grid.points import place_of
from pellucid.grid.stencil import add_vector, gather, stencil
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.joint import joint_region
from pellucid.jit.parallel import parallel_by_colour, parallel_for


@kernel(inner=True)
def _scatter_vectors_slab(s, mapped, values, target):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        vector = (values[p, 0], values[p, 1], values[p, 2])
        add_vector(stencil(functions, lattice, x, p), lattice, target, vector)


@kernel()
def _scatter_vectors(n, mapped, values, target):
    parallel_by_colour(_scatter_vectors_slab, n, mapped.slabs.across, mapped, values, target)


def scatter_vectors(n: int, mapped: Bundle, values: np.ndarray, target: np.ndarray) -> None:
    """Add vectors that the points of n slabs have, shape (points, 3), to those of the nodes, shape (nodes, 3)."""
    joint_region.give_at_once(lambda: _scatter_vectors(n, mapped, values, target), [target])


@kernel()
def scatter_listed(mapped, position, listed, values, target):
    """Add vectors, shape (m, 3), at listed places of `position` [m], shape (points, 3), to those of the nodes; few of them."""
    functions, lattice = mapped.functions, mapped.lattice
    for e in range(len(listed)):
        vector = (values[e, 0], values[e, 1], values[e, 2])
        add_vector(stencil(functions, lattice, position, uintp(listed[e])), lattice, target, vector)


@kernel(inner=True)
def _gather_vectors_slab(s, mapped, nodal, target):
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        vector = gather(stencil(functions, lattice, x, p), lattice, nodal)
        for d in range(3):
            target[p, d] = vector[d]


@kernel()
def gather_vectors(n, mapped, nodal, target):
    """Nodal vectors, shape (nodes, 3), at the points of n slabs into `target`, shape (points, 3)."""
    parallel_for(_gather_vectors_slab, n, mapped, nodal, target)
