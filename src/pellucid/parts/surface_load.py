"""Loads on the surface of a body that asks for them itself, wherever it is at an instant."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np


class SurfacePoints(NamedTuple):
    """Where a load acts at an instant: quadrature points, in an array of any shape."""

    position: np.ndarray  # (..., 3) [m]
    normal: np.ndarray  # (..., 3) outward
    density_ratio: np.ndarray  # (...) to that at the start: initial by present area


Traction = Callable[[SurfacePoints, float], np.ndarray]
"""Force on unit of present area [Pa], shape (..., 3), at a time after the start of the step of the clock [s]."""


class ActingTraction(NamedTuple):
    """A traction that acts on a body over a step."""

    column: int  # of its work
    traction: Traction
    label: str  # by which users know it
