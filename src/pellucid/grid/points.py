"""What the transfers need of a body of points, and how its points are shared out in slabs."""

from typing import NamedTuple

import numpy as np

OK, NOT_FINITE, INVERTED, LOST = 0, 1, 2, 3
FAULTS = {
    NOT_FINITE: "its state is not a finite number",
    INVERTED: "its volume would become zero or negative in this step",
    LOST: "it left the grid",
}


class PointArrays(NamedTuple):
    """What every material point carries; n points, sorted by cell now and then."""

    position: np.ndarray  # (n, 3) [m]
    velocity: np.ndarray  # (n, 3) [m/s]
    mass: np.ndarray  # (n,) [kg]
    volume: np.ndarray  # (n,) [m³]
    stress: np.ndarray  # (n, 6) Cauchy stress xx, yy, zz, yz, xz, xy [Pa]


class Slabs(NamedTuple):
    """Points first[s]:first[s+1] lay in the cell layers layer[s]:layer[s+1] when they were last sorted.

    They may stray one layer beyond before they must be sorted again; slabs are wide enough that two of one colour (even,
    odd) then still reach no common node.
    """

    first: np.ndarray  # (s+1,)
    layer: np.ndarray  # (s+1,)
    fault: np.ndarray  # (s, 2) a code above, and the first point that has it
    strayed: np.ndarray  # (s,) 1 where a point left its slab by more than a layer
    sums: np.ndarray  # (s, columns) partial sums of the reductions


# columns of Slabs.sums
KINETIC, MOMENTUM_X, MOMENTUM_Y, MOMENTUM_Z, SPEED, STORED, HEATING, RATE, COLUMNS = range(9)
