"""Cubic B-splines centred on the nodes (Steffen, Kirby & Berzins 2008)."""

from typing import NamedTuple

from pellucid.approximants.axis import affine_weights, axis_weights, fold4, spread4
from pellucid.jit import point_function


class CubicBSpline(NamedTuple):
    """Shape function along one grid axis: a cubic B-spline. `stencil`: number of nodes whose functions can be non-zero at a
    point."""

    stencil: int = 4


@point_function(axis_weights, CubicBSpline)
def _axis_weights(fn, u, n):
    i = min(max(int(u), 0), n - 1)
    f = u - i
    r = 1.0 - f
    sixth = 1.0 / 6.0
    w = (
        sixth * r * r * r,
        2.0 / 3.0 - f * f + 0.5 * f * f * f,
        2.0 / 3.0 - r * r + 0.5 * r * r * r,
        sixth * f * f * f,
    )
    g = (-0.5 * r * r, 1.5 * f * f - 2.0 * f, 2.0 * r - 1.5 * r * r, 0.5 * f * f)
    first, w = fold4(i - 1, n, w)
    first, g = fold4(i - 1, n, g)
    return first, w, g


@point_function(affine_weights, CubicBSpline)
def _affine_weights(fn, offset, w, g):
    return spread4(offset, w, g)
