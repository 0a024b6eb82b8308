"""Integrals of one-dimensional shape functions over whole cells. Their products along the axes are the integrals of the
grid's shape functions."""

from typing import Any, NamedTuple

import numpy as np

from pellucid.approximants import PeriodicAxis
from pellucid.approximants.grid_functions import axis_weights

PARTS = 120  # a multiple of 2, 3, 4 and 5: functions averaged over such a fraction of a cell have kinks at ends of parts only
"""Number of parts of a cell for the integration, each by two-point Gauss quadrature (exact for cubics)."""
NEAR = 5  # distance from a wall [cells], beyond which the integrals are the same in all cells


class AxisIntegrals(NamedTuple):
    """Values and derivatives of the shape functions along an axis, integrated over each of its n cells in the coordinate u
    [cells]; w nodes have functions that are not zero in a cell."""

    first: np.ndarray  # (n,) first node whose function is not zero in each cell
    value: np.ndarray  # (n, w) ∫ N du
    slope: np.ndarray  # (n, w) ∫ N' du


def axis_integrals(function: Any, n: int) -> AxisIntegrals:
    """Compute the integrals of a shape function along an axis, and of its derivative, over each of its n cells; function: see
    `pellucid.approximants.grid_functions.GridFunction`."""
    if isinstance(function, PeriodicAxis):
        far = axis_integrals(function.function, 2 * NEAR + 1)  # of which the middle knows of no wall
        starts = (np.arange(n) + far.first[NEAR] - NEAR) % n
        return AxisIntegrals(starts, *(np.tile(of[NEAR], (n, 1)) for of in (far.value, far.slope)))
    cells = min(n, 2 * NEAR + 1)
    value, slope = np.zeros((2, cells, cells + 4))
    gauss = (0.5 + np.array([-0.5, 0.5]) / np.sqrt(3.0)) / PARTS
    for cell in range(cells):
        for u in (cell + np.arange(PARTS)[:, None] / PARTS + gauss).ravel():
            first, w, _ = axis_weights(function, u, cells)
            value[cell, first : first + len(w)] += 0.5 / PARTS * np.array(w)
        for u, sign in ((float(cell), -1.0), (cell + 1.0, 1.0)):
            first, w, _ = axis_weights(function, u, cells)
            slope[cell, first : first + len(w)] += sign * np.array(w)
    reached = (value != 0.0) | (slope != 0.0)
    start = reached.argmax(axis=1)
    width = max(np.flatnonzero(row)[-1] + 1 - at for row, at in zip(reached, start, strict=True))
    columns = start[:, None] + np.arange(width)
    number = np.arange(n)
    like = np.where(number < n - NEAR, np.minimum(number, NEAR), number - n + cells) if n > cells else number
    value, slope = (np.take_along_axis(table, columns, axis=1)[like] for table in (value, slope))
    return AxisIntegrals(start[like] + number - like, value, slope)
