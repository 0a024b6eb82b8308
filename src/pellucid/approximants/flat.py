"""The function of an axis that is one cell thick: one node, the same everywhere. It makes a slab a plane or a line."""

from typing import NamedTuple

from pellucid.approximants.axis import affine_weights, axis_weights
from pellucid.jit import point_function


class Flat(NamedTuple):
    """One node."""

    stencil: int = 1


@point_function(axis_weights, Flat)
def _axis_weights(fn, u, n):
    return 0, (1.0,), (0.0,)


@point_function(affine_weights, Flat)
def _affine_weights(fn, offset, w, g):
    return g
