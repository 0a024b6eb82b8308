"""Constant function along an axis that is one cell thick, with a single node: it reduces a problem to two dimensions or one."""

from typing import NamedTuple

from pellucid.approximants.axis import affine_weights, axis_numbers, axis_values, axis_weights
from pellucid.jit import point_function


class Flat(NamedTuple):
    """Shape function along a grid axis that is one cell thick: constant, with the value 1. `stencil`: the axis has a single
    node."""

    stencil: int = 1


@point_function(axis_weights, Flat)
def _axis_weights(fn, u, n):
    return 0, (1.0,), (0.0,)


@point_function(axis_numbers, Flat)
def _axis_numbers(fn, u, n):
    return 0, (-u,)


@point_function(axis_values, Flat)
def _axis_values(fn, numbers):
    return numbers[0], (1.0,), (0.0,)


@point_function(affine_weights, Flat)
def _affine_weights(fn, offset, w, g):
    return g
