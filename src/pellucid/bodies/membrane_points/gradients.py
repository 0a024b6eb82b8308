"""Loop over membrane points that gathers their velocity gradients from the grid and moves the points. It is separate because
straining requires all points at their new positions."""

from typing import Any, NamedTuple

import numpy as np

from pellucid.grid.passes.points_pass import Declaration, Found, at_point, pass_points
from pellucid.grid.points import MappedPoints, NoCells
from pellucid.grid.straining import MOTION_LIKE, AtPosition, GatherMotion
from pellucid.jit import point_function
from pellucid.jit.bundle import Bundle
from pellucid.tensors import ZERO_VECTOR


class Read(NamedTuple):
    """Data that the loop which gathers velocity gradients reads: the position of one point, or the array of all positions."""

    position: Any  # [m]


class Kept(NamedTuple):
    """Data that the loop which gathers velocity gradients writes: new position and velocity gradient of one point, or the
    arrays for all points.
    """

    position: Any  # new position [m]
    gradient: Any  # velocity gradient [1/s]


class GatherGradient(NamedTuple):
    """Task of the loop: keep the velocity gradients that `GatherMotion` gathers, and compute new positions if points move."""

    moving: float  # 1 if the points move, else 0


@point_function(at_point, GatherGradient)
def _move(task, lattice, dt, p, known, g):
    (x, y, z), (L, u), step = p.position, g, task.moving * dt
    return Found(Kept((x + step * u[0], y + step * u[1], z + step * u[2]), L), (), 0.0, 0.0)


def gathering_gradients(mapped: MappedPoints, gradient: np.ndarray, moving: bool) -> Bundle:
    """Build the loop over the points of a membrane that writes their velocity gradients to `gradient`, shape (points, 9) [1/s],
    and moves them if `moving`."""
    declared = Declaration(gathers=MOTION_LIKE, rule=GatherMotion(NoCells()), rule_reads=AtPosition(ZERO_VECTOR), places=True)
    position = mapped.points.position
    return pass_points(GatherGradient(float(moving)), declared, mapped, Read(position), Kept(position, gradient))
