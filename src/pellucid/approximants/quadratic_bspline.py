"""Quadratic B-splines centred on the nodes (Steffen, Kirby & Berzins 2008)."""

from typing import NamedTuple

from pellucid.approximants.axis import affine_weights, axis_weights, fold3, spread3
from pellucid.jit import point_function


class QuadraticBSpline(NamedTuple):
    """Shape function along one grid axis: a quadratic B-spline. `stencil`: number of nodes whose functions can be non-zero
    at a point."""

    stencil: int = 3


@point_function(axis_weights, QuadraticBSpline)
def _axis_weights(fn, u, n):
    i = min(max(int(u + 0.5), 0), n)
    f = u - i
    first, w = fold3(i - 1, n, (0.5 * (0.5 - f) * (0.5 - f), 0.75 - f * f, 0.5 * (0.5 + f) * (0.5 + f)))
    first, g = fold3(i - 1, n, (f - 0.5, -2.0 * f, f + 0.5))
    return first, w, g


@point_function(affine_weights, QuadraticBSpline)
def _affine_weights(fn, offset, w, g):
    return spread3(offset, w, g)
