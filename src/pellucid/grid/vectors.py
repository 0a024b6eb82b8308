"""Transfer of vectors, such as forces, from points to nodes and from nodes to points."""

from numpy import uintp

from pellucid.grid.points import place_of
from pellucid.grid.stencil import add_vector, gather, stencil
from pellucid.jit import kernel
from pellucid.jit.loops import parallel_loop, parallel_loop_by_colour


@parallel_loop_by_colour(gives="target")
def scatter_vectors(s, mapped, values, target):
    """Map vectors of points to nodes: add Σ N times the vectors of the points of slab s (see `Slabs`) to `target`, shape
    (nodes, 3).

    mapped: the points (`MappedPoints`); values: vectors of all points, shape (points, 3).
    """
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        vector = (values[p, 0], values[p, 1], values[p, 2])
        add_vector(stencil(functions, lattice, x, p), lattice, target, vector)


@kernel()
def scatter_listed(mapped, position, listed, values, target):
    """Map vectors of m listed points to nodes: add Σ N times the vectors to `target`, shape (nodes, 3).

    mapped: grid and shape functions (`MappedPoints`); position: positions of all points [m], shape (points, 3); listed:
    numbers of the points, shape (m,); values: vectors of the listed points, shape (m, 3).
    """
    functions, lattice = mapped.functions, mapped.lattice
    for e in range(len(listed)):
        vector = (values[e, 0], values[e, 1], values[e, 2])
        add_vector(stencil(functions, lattice, position, uintp(listed[e])), lattice, target, vector)


@parallel_loop()
def gather_vectors(s, mapped, nodal, target):
    """Interpolate nodal vectors, shape (nodes, 3), to the points of slab s (see `Slabs`), into `target`, shape (points, 3);
    mapped: the points (`MappedPoints`)."""
    functions, lattice, index = mapped.functions, mapped.lattice, mapped.index
    x, slabs = mapped.points.position, mapped.slabs
    for q in range(slabs.first[s], slabs.first[s + 1]):
        p = place_of(index, q)
        vector = gather(stencil(functions, lattice, x, p), lattice, nodal)
        for d in range(3):
            target[p, d] = vector[d]
