"""Loads on the surface of a body that evaluates the loads itself, at any time within a step."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np


class SurfacePoints(NamedTuple):
    """Quadrature points on a surface, at which a load is evaluated at one time, in arrays of any shape."""

    position: np.ndarray  # (..., 3) positions [m]
    normal: np.ndarray  # (..., 3) outward unit normals
    density_ratio: np.ndarray  # (...) current over initial areal density, i.e. initial over current area


Traction = Callable[[SurfacePoints, float], np.ndarray]
"""Force per current area [Pa], shape (..., 3), at a time after the start of the step of the clock [s]."""


class ActingTraction(NamedTuple):
    """A traction (force per unit area) that acts on a body over a step."""

    column: int  # column of the work of the traction in a row of works
    traction: Traction  # function of points on the surface and time that returns the traction [Pa]
    label: str  # name of the load for users
