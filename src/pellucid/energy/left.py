"""What points take along that leave a body."""

from typing import NamedTuple

import numpy as np


class Left(NamedTuple):
    """Points that left a body in a step, and what they had at its end."""

    points: int
    mass: float  # [kg]
    momentum: np.ndarray  # (3,) [kg m/s]
    kinetic: float  # [J]
    stored: float  # internal or strain energy [J]
    half_power: float  # half the power of their internal forces, as in `Totals` [W]
