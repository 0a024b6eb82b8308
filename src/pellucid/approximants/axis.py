"""Interface of grid shape functions, which are products of functions along the axes.

A node beyond a wall is folded onto the wall by linear extrapolation, u₋₁ = 2u₀ - u₁. This preserves the partition of unity and
linear fields, and makes the shape function of the wall node interpolate there (Steffen, Kirby & Berzins 2008, Int. J. Numer.
Methods Eng. 76, 922, use the same boundary functions for cubic splines).
"""

from typing import Any, NamedTuple, Protocol

from pellucid.jit import default_function, generic, pointwise

# [cells²]; close to a wall the second moment of the weights vanishes, and dividing by less would lose digits of a linear field
LEAST_SPREAD = 1e-4


class GridFunction(Protocol):
    """Parameters of a shape function along one axis, a NamedTuple; `stencil`: number of nodes in its support."""

    @property
    def stencil(self) -> int: ...


class LinearFunctions(NamedTuple):
    """Functions along x, y, z, whose product is the shape function, with at most two nodes per axis.

    They are linear, with the same slopes at all points.
    """

    x: GridFunction
    y: GridFunction
    z: GridFunction


class CurvedFunctions(NamedTuple):
    """Functions along x, y, z, whose product is the shape function, with more than two nodes along an axis."""

    x: GridFunction
    y: GridFunction
    z: GridFunction


GridFunctions = LinearFunctions | CurvedFunctions


@generic
def axis_weights(fn: Any, u: float, n: int) -> Any:
    """Return the first node, and the weights and derivatives by u at coordinate u (in cells from the wall).

    n: number of cells along the axis. The tuples have `fn.stencil` entries.
    """


@generic
def axis_numbers(fn: Any, u: float, n: int) -> Any:
    """Return the first node around a coordinate, and the numbers from which `axis_values` computes offset, weights and
    derivatives."""


@generic
def axis_values(fn: Any, numbers: Any) -> Any:
    """Return the offset of the first node from the point in cells, and the weights and derivatives of the nodes: vectors if
    `numbers` are vectors, else scalars."""


@default_function(axis_numbers)
def _all(fn, u, n):
    i, w, g = axis_weights(fn, u, n)
    return i, (i - u, w, g)


@default_function(axis_values)
def _same(fn, numbers):
    return numbers


@generic
def affine_weights(fn: Any, offset: float, w: Any, g: Any) -> Any:
    """Return the weights that replace derivatives in the affine field of APIC: w (x_I - x) / Σ w (x_I - x)², in cells.

    offset: first node minus the point, in cells; w, g: weights and derivatives at the point.
    """


@pointwise
def spread3(offset, w, g):
    """Return the `affine_weights` of three nodes; for a point on a wall, where the functions interpolate, their derivatives."""
    r0, r1, r2 = w[0] * offset, w[1] * (offset + 1.0), w[2] * (offset + 2.0)
    spread = r0 * offset + r1 * (offset + 1.0) + r2 * (offset + 2.0)
    if spread < LEAST_SPREAD:
        return g
    return (r0 / spread, r1 / spread, r2 / spread)


@pointwise
def spread4(offset, w, g):
    """Return `affine_weights` of four nodes; see `spread3`."""
    r0, r1, r2, r3 = w[0] * offset, w[1] * (offset + 1.0), w[2] * (offset + 2.0), w[3] * (offset + 3.0)
    spread = r0 * offset + r1 * (offset + 1.0) + r2 * (offset + 2.0) + r3 * (offset + 3.0)
    if spread < LEAST_SPREAD:
        return g
    return (r0 / spread, r1 / spread, r2 / spread, r3 / spread)


@pointwise
def fold3(first, n, w):
    """Fold the weights of three nodes beyond a wall back onto it. Node n+1 exists in memory, with weight zero."""
    if first < 0:
        w = (w[1] + 2.0 * w[0], w[2] - w[0], 0.0)
        first = 0
    if first + 2 > n:
        w = (w[0] - w[2], w[1] + 2.0 * w[2], 0.0)
    return first, w


@pointwise
def fold4(first, n, w):
    """Fold the weights of four nodes; see `fold3`."""
    if first < 0:
        w = (w[1] + 2.0 * w[0], w[2] - w[0], w[3], 0.0)
        first = 0
    if first + 2 > n:
        w = (w[0] - w[2], w[1] + 2.0 * w[2], 0.0, 0.0)
    elif first + 3 > n:
        w = (w[0], w[1] - w[3], w[2] + 2.0 * w[3], 0.0)
    return first, w
