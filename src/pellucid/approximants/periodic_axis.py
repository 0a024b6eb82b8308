"""Function of a periodic axis: node i is the same as node i + n for n cells, and there is no wall."""

from typing import Any, NamedTuple

from numpy import floor

from pellucid.approximants.axis import affine_weights, axis_numbers, axis_values, axis_weights
from pellucid.jit import point_function, pointwise

FAR = 4
"""Distance from a wall, in cells, beyond which the shape functions do not depend on the wall."""


class PeriodicAxis(NamedTuple):
    """Shape function along a periodic grid axis. `function`: shape function of an axis with walls, evaluated far from the
    walls; its node numbers are then reduced to the period. `stencil`: number of nodes whose functions can be non-zero at a
    point."""

    function: Any
    stencil: int


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
def _axis_weights(fn, u, n):
    i, w, g = axis_weights(fn.function, _far_from_walls(u, n), n + 2 * FAR)
    return _within(i, n), w, g


@point_function(axis_numbers, PeriodicAxis)
def _axis_numbers(fn, u, n):
    i, numbers = axis_numbers(fn.function, _far_from_walls(u, n), n + 2 * FAR)
    return _within(i, n), numbers


@point_function(axis_values, PeriodicAxis)
def _axis_values(fn, numbers):
    return axis_values(fn.function, numbers)


@point_function(affine_weights, PeriodicAxis)
def _affine_weights(fn, offset, w, g):
    return affine_weights(fn.function, offset, w, g)
