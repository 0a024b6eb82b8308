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
    """Interface of a shape function along one grid axis: a NamedTuple of the parameters of the function. `stencil`: number
    of nodes whose shape functions can be non-zero at a point."""

    @property
    def stencil(self) -> int: ...


class LinearFunctions(NamedTuple):
    """Shape functions along x, y, z, whose product is the shape function of a node, with at most two nodes per axis.

    They are linear within a cell, so their derivatives along their own axis are the same at all points of the cell.
    """

    x: GridFunction
    y: GridFunction
    z: GridFunction


class CurvedFunctions(NamedTuple):
    """Shape functions along x, y, z, whose product is the shape function of a node, with more than two nodes along an axis."""

    x: GridFunction
    y: GridFunction
    z: GridFunction


GridFunctions = LinearFunctions | CurvedFunctions


@generic
def axis_weights(fn: Any, u: float, n: int) -> Any:
    """Return the number of the first node of the support, and the values (weights) and derivatives [1/cell] of the shape
    functions of all its nodes at the coordinate u [cells from the lower end of the axis].

    fn: shape function along the axis, see `GridFunction`. n: number of cells along the axis. The tuples of weights and
    derivatives have `fn.stencil` entries.
    """


@generic
def axis_numbers(fn: Any, u: float, n: int) -> Any:
    """Return the number of the first node of the support of the shape function fn at the coordinate u [cells], and the numbers
    from which `axis_values` computes offset, weights and derivatives; n: number of cells along the axis."""


@generic
def axis_values(fn: Any, numbers: Any) -> Any:
    """Return the position of the first node of the support minus that of the point [cells], and the values (weights) and
    derivatives [1/cell] of the shape functions of all its nodes; fn: shape function along the axis; numbers: second result
    of `axis_numbers`, as scalars for one point or vectors for several points."""


@default_function(axis_numbers)
def _all(fn, u, n):
    i, w, g = axis_weights(fn, u, n)
    return i, (i - u, w, g)


@default_function(axis_values)
def _same(fn, numbers):
    return numbers


@generic
def affine_weights(fn: Any, offset: float, w: Any, g: Any) -> Any:
    """Return the factors w (x_I - x) / Σ w (x_I - x)² [1/cell] of the nodes x_I along an axis: in the affine velocity field of
    APIC they replace the derivatives of the shape functions at the point x.

    fn: shape function along the axis; offset: position of the first node minus x [cells]; w, g: values and derivatives
    [1/cell] of the shape functions of the nodes at x.
    """


@pointwise
def spread3(offset, w, g):
    """Return the factors w (x_I - x) / Σ w (x_I - x)² [1/cell] (see `affine_weights`) of the three nodes x_I around a point
    x along an axis; at a wall, where the sum vanishes, return the derivatives g.

    offset: position of the first node minus x [cells]; w, g: values and derivatives [1/cell] of the shape functions of the
    nodes at x.
    """
    r0, r1, r2 = w[0] * offset, w[1] * (offset + 1.0), w[2] * (offset + 2.0)
    spread = r0 * offset + r1 * (offset + 1.0) + r2 * (offset + 2.0)
    if spread < LEAST_SPREAD:
        return g
    return (r0 / spread, r1 / spread, r2 / spread)


@pointwise
def spread4(offset, w, g):
    """Return the factors w (x_I - x) / Σ w (x_I - x)² [1/cell] (see `affine_weights`) of the four nodes x_I around a point
    x along an axis; at a wall, where the sum vanishes, return the derivatives g.

    offset: position of the first node minus x [cells]; w, g: values and derivatives [1/cell] of the shape functions of the
    nodes at x.
    """
    r0, r1, r2, r3 = w[0] * offset, w[1] * (offset + 1.0), w[2] * (offset + 2.0), w[3] * (offset + 3.0)
    spread = r0 * offset + r1 * (offset + 1.0) + r2 * (offset + 2.0) + r3 * (offset + 3.0)
    if spread < LEAST_SPREAD:
        return g
    return (r0 / spread, r1 / spread, r2 / spread, r3 / spread)


@pointwise
def fold3(first, n, w):
    """Return the first node and the weights of three nodes along an axis after the weight of a node beyond a wall is
    transferred to the nodes at the wall by linear extrapolation.

    first: number of the first node, -1 if it is beyond the lower wall; w: values or derivatives of the three shape
    functions; n: number of cells. Node n + 1 exists in memory and may be listed with weight zero.
    """
    if first < 0:
        w = (w[1] + 2.0 * w[0], w[2] - w[0], 0.0)
        first = 0
    if first + 2 > n:
        w = (w[0] - w[2], w[1] + 2.0 * w[2], 0.0)
    return first, w


@pointwise
def fold4(first, n, w):
    """Return the first node and the weights of four nodes along an axis after the weights of nodes beyond a wall are
    transferred to the nodes at the wall by linear extrapolation.

    first: number of the first node, -1 if it is beyond the lower wall; n: number of cells; w: values or derivatives of the
    four shape functions.
    """
    if first < 0:
        w = (w[1] + 2.0 * w[0], w[2] - w[0], w[3], 0.0)
        first = 0
    if first + 2 > n:
        w = (w[0] - w[2], w[1] + 2.0 * w[2], 0.0, 0.0)
    elif first + 3 > n:
        w = (w[0], w[1] - w[3], w[2] + 2.0 * w[3], 0.0)
    return first, w
