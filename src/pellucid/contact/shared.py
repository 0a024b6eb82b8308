"""The nodes that two velocity fields share, listed and numbered, and the points that may reach them: kernels."""

from math import inf
from typing import Annotated, NamedTuple

import numpy as np

from pellucid.grid.folding import cells_beyond, nodes_before
from pellucid.grid.momentum import MASS_EPS
from pellucid.grid.nodal_fields import FOUND, RUN, NodalField, fields_of
from pellucid.jit import kernel, pointwise

MARGIN = 1e-6  # of a cell, for rounding


class SharedNodes(NamedTuple):
    """Where the numbered nodes are, over all nodes of the grid."""

    slot: Annotated[np.ndarray, NodalField(1, FOUND, RUN, "", "number of a node that two fields share, else -1", np.int32)]
    near: Annotated[np.ndarray, NodalField(1, FOUND, RUN, "", "1 where a stencil that begins here holds such a node", np.uint8)]
    box: np.ndarray  # (2, 3) the points beyond it reach none [m]


def no_numbers(n: int) -> tuple[np.ndarray, np.ndarray]:
    """`slot` and `near` of a grid of n nodes, none of which has a number."""
    slot, near = (fields_of(SharedNodes)[name].allocate(n) for name in ("slot", "near"))
    slot.fill(-1)
    return slot, near


@kernel()
def list_shared(first, second, node):
    """The nodes that have mass of both velocity fields into `node`; how many they are."""
    n = 0
    for I in range(len(first)):
        if first[I] > MASS_EPS and second[I] > MASS_EPS:
            node[n] = I
            n += 1
    return n


@kernel()
def list_shared_of(reached, first, second, node):
    """The same where no nodes but those in `reached` can be shared."""
    n = 0
    for e in range(len(reached)):
        I = reached[e]
        if first[I] > MASS_EPS and second[I] > MASS_EPS:
            node[n] = I
            n += 1
    return n


@kernel()
def mark_stencils(node, slot, near, reach, lattice, on):
    """Number the nodes in `slot`, and flag the first nodes of all stencils that hold one of them; or take both back."""
    for e in range(len(node)):
        I = node[e]
        slot[I] = e if on else -1
        for a in range(reach[0]):
            for b in range(reach[1]):
                for c in range(reach[2]):
                    first = nodes_before(lattice.folding, lattice, I, a, b, c)
                    if first >= 0:
                        near[first] = 1 if on else 0


@kernel()
def bounding_box(node, lattice, reach, box):
    """The box, (2, 3) [m], of the points that may have weight at a listed node; stencils have `reach` nodes along each axis."""
    s, slow = lattice.strides, lattice.slab_axis
    middle = 1 if slow == 0 else 0  # the order of the axes in memory
    fast = 3 - slow - middle
    for d in range(3):
        box[0, d], box[1, d] = inf, -inf
    for e in range(len(node)):
        rest = node[e] % s[slow]
        for d, i in ((slow, node[e] // s[slow]), (middle, rest // s[middle]), (fast, rest % s[middle])):
            box[0, d], box[1, d] = min(box[0, d], i), max(box[1, d], i)
    for d in range(3):
        wide = 0.5 * reach[d] + MARGIN
        box[0, d] = lattice.lower[d] + (box[0, d] - wide) * lattice.cell
        box[1, d] = lattice.lower[d] + (box[1, d] + wide) * lattice.cell
        if cells_beyond(lattice.folding, d) > 0:  # points may have crossed it any number of times
            box[0, d], box[1, d] = -inf, inf


@pointwise
def beyond(where, x, p):
    """Whether point p lies outside the box."""
    box = where.box
    below = x[p, 0] < box[0, 0] or x[p, 1] < box[0, 1] or x[p, 2] < box[0, 2]
    return below or x[p, 0] > box[1, 0] or x[p, 1] > box[1, 1] or x[p, 2] > box[1, 2]
