"""Trilinear shape functions of the original material point method (Sulsky, Chen & Schreyer 1994)."""

from typing import NamedTuple

from numpy import floor

from pellucid.approximants.axis import affine_weights, axis_numbers, axis_values, axis_weights
from pellucid.jit import point_function, pointwise


class Trilinear(NamedTuple):
    """Shape function along one grid axis: linear between neighbouring nodes. `stencil`: number of nodes whose functions can
    be non-zero at a point."""

    stencil: int = 2


@pointwise
def _cell(u, n):
    i = floor(u)
    i = i if i > 0.0 else 0.0  # also replaces NaN, which must not index memory outside the grid
    return i if i < n - 1.0 else n - 1.0


@point_function(axis_weights, Trilinear)
def _axis_weights(fn, u, n):
    i = _cell(u, n)
    f = u - i
    return int(i), (1.0 - f, f), (-1.0, 1.0)


@point_function(axis_numbers, Trilinear)
def _axis_numbers(fn, u, n):
    i = _cell(u, n)
    return i, (u - i,)


@point_function(axis_values, Trilinear)
def _axis_values(fn, numbers):
    f = numbers[0]
    return -1.0 * f, (1.0 - f, f), (-1.0, 1.0)


@point_function(affine_weights, Trilinear)
def _affine_weights(fn, offset, w, g):
    return g
