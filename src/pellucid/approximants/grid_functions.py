"""Interface of grid shape functions, which are products of functions along the axes.

A node beyond a wall is folded onto the wall by linear extrapolation, u₋₁ = 2u₀ - u₁. This preserves the partition of unity and
linear fields, and makes the shape function of the wall node interpolate there (Steffen, Kirby & Berzins 2008, Int. J. Numer.
Methods Eng. 76, 922, use the same boundary functions for cubic splines).
"""

from typing import Any, NamedTuple, Protocol

from numpy import floor

from pellucid.jit import default_function, generic, point_function, pointwise

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


class Trilinear(NamedTuple):
    """Linear between neighbouring nodes (Sulsky, Chen & Schreyer 1994)."""

    stencil: int = 2


@pointwise
def _cell(u, n):
    i = floor(u)
    i = i if i > 0.0 else 0.0  # also replaces NaN, which must not index memory outside the grid
    return i if i < n - 1.0 else n - 1.0


@point_function(axis_weights, Trilinear)
def _trilinear_weights(fn, u, n):
    i = _cell(u, n)
    f = u - i
    return int(i), (1.0 - f, f), (-1.0, 1.0)


@point_function(axis_numbers, Trilinear)
def _trilinear_numbers(fn, u, n):
    i = _cell(u, n)
    return i, (u - i,)


@point_function(axis_values, Trilinear)
def _trilinear_values(fn, numbers):
    f = numbers[0]
    return -1.0 * f, (1.0 - f, f), (-1.0, 1.0)


class Gimp(NamedTuple):
    """Tents averaged over the initial edge length of a point, uniform generalised interpolation (uGIMP, Bardenhagen & Kober
    2004). `half`: half the edge length of a material point along the axis [cells], at most ½."""

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
def _gimp_weights(fn, u, n):
    l = fn.half
    i = min(max(int(u - l + 1.0) - 1, -1), n - 1)
    w0, g0 = _averaged_tent(u - i, l)
    w1, g1 = _averaged_tent(u - i - 1.0, l)
    w2, g2 = _averaged_tent(u - i - 2.0, l)
    first, w = fold3(i, n, (w0, w1, w2))
    first, g = fold3(i, n, (g0, g1, g2))
    return first, w, g


class QuadraticBSpline(NamedTuple):
    """A quadratic B-spline centred on the node (Steffen, Kirby & Berzins 2008)."""

    stencil: int = 3


@point_function(axis_weights, QuadraticBSpline)
def _quadratic_bspline_weights(fn, u, n):
    i = min(max(int(u + 0.5), 0), n)
    f = u - i
    first, w = fold3(i - 1, n, (0.5 * (0.5 - f) * (0.5 - f), 0.75 - f * f, 0.5 * (0.5 + f) * (0.5 + f)))
    first, g = fold3(i - 1, n, (f - 0.5, -2.0 * f, f + 0.5))
    return first, w, g


class CubicBSpline(NamedTuple):
    """A cubic B-spline centred on the node (Steffen, Kirby & Berzins 2008)."""

    stencil: int = 4


@point_function(axis_weights, CubicBSpline)
def _cubic_bspline_weights(fn, u, n):
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


class Flat(NamedTuple):
    """Constant, with the value 1, along an axis that is one cell thick, with a single node: it reduces a problem to two
    dimensions or one."""

    stencil: int = 1


@point_function(axis_weights, Flat)
def _flat_weights(fn, u, n):
    return 0, (1.0,), (0.0,)


@point_function(axis_numbers, Flat)
def _flat_numbers(fn, u, n):
    return 0, (-u,)


@point_function(axis_values, Flat)
def _flat_values(fn, numbers):
    return numbers[0], (1.0,), (0.0,)


FAR = 4
"""Distance from a wall, in cells, beyond which the shape functions do not depend on the wall."""


class PeriodicAxis(NamedTuple):
    """Function of a periodic axis: node i is the same as node i + n for n cells, and there is no wall. `function`: shape
    function of an axis with walls, evaluated far from the walls; its node numbers are then reduced to the period."""

    function: Any
    stencil: int


class MirroredAxis(NamedTuple):
    """Function of an axis with a plane of symmetry at one end or both: the same function as far from walls. It lists nodes
    beyond the plane, whose values follow from those of their mirror images, see `pellucid.grid.folding`. `function`: shape
    function of an axis with walls; lower, upper: FAR at a plane of symmetry, else 0."""

    function: Any
    stencil: int
    lower: int
    upper: int


@pointwise
def _far_from_walls(u, n):
    """Return the coordinate u [cells], folded into the period of n cells and shifted by FAR cells, so that the walls of the
    wrapped function do not affect its values."""
    return u - n * floor(u / n) + FAR


@pointwise
def _within(i, n):
    """Return the number within the period of n nodes (0 to n - 1) of node i, which was found at a coordinate shifted by
    `_far_from_walls`."""
    first = i - FAR
    first = first + n if first < 0 else first
    return first - n if first >= n else first


@point_function(axis_weights, PeriodicAxis)
def _periodic_axis_weights(fn, u, n):
    i, w, g = axis_weights(fn.function, _far_from_walls(u, n), n + 2 * FAR)
    return _within(i, n), w, g


@point_function(axis_numbers, PeriodicAxis)
def _periodic_axis_numbers(fn, u, n):
    i, numbers = axis_numbers(fn.function, _far_from_walls(u, n), n + 2 * FAR)
    return _within(i, n), numbers


@point_function(axis_values, PeriodicAxis)
def _periodic_axis_values(fn, numbers):
    return axis_values(fn.function, numbers)


@point_function(axis_weights, MirroredAxis)
def _mirrored_axis_weights(fn, u, n):
    i, w, g = axis_weights(fn.function, u + fn.lower, n + fn.lower + fn.upper)
    return min(max(i - fn.lower, -1 if fn.lower > 0 else 0), n - 1), w, g  # of any u, also NaN, nodes that exist


@point_function(affine_weights, Flat)
@point_function(affine_weights, Trilinear)
def _affine_of_two(fn, offset, w, g):
    return g


@point_function(affine_weights, Gimp)
@point_function(affine_weights, QuadraticBSpline)
def _affine_of_three(fn, offset, w, g):
    r0, r1, r2 = w[0] * offset, w[1] * (offset + 1.0), w[2] * (offset + 2.0)
    spread = r0 * offset + r1 * (offset + 1.0) + r2 * (offset + 2.0)
    if spread < LEAST_SPREAD:
        return g
    return (r0 / spread, r1 / spread, r2 / spread)


@point_function(affine_weights, CubicBSpline)
def _affine_of_four(fn, offset, w, g):
    r0, r1, r2, r3 = w[0] * offset, w[1] * (offset + 1.0), w[2] * (offset + 2.0), w[3] * (offset + 3.0)
    spread = r0 * offset + r1 * (offset + 1.0) + r2 * (offset + 2.0) + r3 * (offset + 3.0)
    if spread < LEAST_SPREAD:
        return g
    return (r0 / spread, r1 / spread, r2 / spread, r3 / spread)


@point_function(affine_weights, MirroredAxis)
@point_function(affine_weights, PeriodicAxis)
def _periodic_axis_affine(fn, offset, w, g):
    return affine_weights(fn.function, offset, w, g)
