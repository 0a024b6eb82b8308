"""Vectors between points and nodes: forces and other vectors that points have, to the nodes; nodal vectors to the points."""

from numpy import uintp

from pellucid.grid.points import place_of
from pellucid.grid.stencil import add_vector, gather, stencil
from pellucid.jit import kernel
from pellucid.jit.loops import parallel_loop, parallel_loop_by_colour


@parallel_loop_by_colour(gives="target")
def scatter_vectors(s, mapped, values, target):
    """Add vectors that the points of n slabs have, shape (points, 3), to those of the nodes, shape (nodes, 3)."""
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        vector = (values[p, 0], values[p, 1], values[p, 2])
        add_vector(stencil(functions, lattice, x, p), lattice, target, vector)


@kernel()
def scatter_listed(mapped, position, listed, values, target):
    """Add vectors, shape (m, 3), at listed places of `position` [m], shape (points, 3), to those of the nodes; few of them."""
    functions, lattice = mapped.functions, mapped.lattice
    for e in range(len(listed)):
        vector = (values[e, 0], values[e, 1], values[e, 2])
        add_vector(stencil(functions, lattice, position, uintp(listed[e])), lattice, target, vector)


@parallel_loop()
def gather_vectors(s, mapped, nodal, target):
    """Nodal vectors, shape (nodes, 3), at the points of n slabs into `target`, shape (points, 3)."""
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        vector = gather(stencil(functions, lattice, x, p), lattice, nodal)
        for d in range(3):
            target[p, d] = vector[d]
