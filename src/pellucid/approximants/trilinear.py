"""Trilinear functions, the original ones of the material point method (Sulsky, Chen & Schreyer 1994)."""

from typing import NamedTuple

from pellucid.approximants.axis import affine_weights, axis_weights
from pellucid.jit import point_function


class Trilinear(NamedTuple):
    """Two nodes along each axis."""

    stencil: int = 2


@point_function(axis_weights, Trilinear)
def _axis_weights(fn, u, n):
    i = min(max(int(u), 0), n - 1)
    f = u - i
    return i, (1.0 - f, f), (-1.0, 1.0)


@point_function(affine_weights, Trilinear)
def _affine_weights(fn, offset, w, g):
    return g
