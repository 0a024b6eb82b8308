"""Uniform generalised interpolation (uGIMP, Bardenhagen & Kober 2004): tents averaged over the initial edge length 2l of a
point."""

from typing import NamedTuple

from pellucid.approximants.axis import affine_weights, axis_weights, fold3, spread3
from pellucid.jit import point_function, pointwise


class Gimp(NamedTuple):
    """Shape function along one grid axis by uniform generalised interpolation (uGIMP). `half`: half the edge length of a
    material point along the axis [cells], at most ½; `stencil`: number of nodes whose functions can be non-zero at a point."""

    half: float
    stencil: int = 3


@pointwise
def _averaged_tent(r, l):
    """Return a linear tent function (1 at its node, 0 at the neighbours) averaged over the edge 2l of a material point, and the
    derivative of the average [1/cell]; r: position of the point minus that of the node, l: half the edge, both in cells."""
    s = abs(r)
    sign = 1.0 if r >= 0.0 else -1.0
    if s < l:
        return 1.0 - (r * r + l * l) / (2.0 * l), -r / l
    if s <= 1.0 - l:
        return 1.0 - s, -sign
    if s < 1.0 + l:
        reach = 1.0 + l - s
        return reach * reach / (4.0 * l), -sign * reach / (2.0 * l)
    return 0.0, 0.0


@point_function(axis_weights, Gimp)
def _axis_weights(fn, u, n):
    l = fn.half
    i = min(max(int(u - l + 1.0) - 1, -1), n - 1)
    w0, g0 = _averaged_tent(u - i, l)
    w1, g1 = _averaged_tent(u - i - 1.0, l)
    w2, g2 = _averaged_tent(u - i - 2.0, l)
    first, w = fold3(i, n, (w0, w1, w2))
    first, g = fold3(i, n, (g0, g1, g2))
    return first, w, g


@point_function(affine_weights, Gimp)
def _affine_weights(fn, offset, w, g):
    return spread3(offset, w, g)
