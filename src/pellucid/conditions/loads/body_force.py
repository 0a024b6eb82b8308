"""An acceleration of one body."""

from typing import Literal

import numpy as np

from pellucid.conditions.loads.contract import Load, PointsView
from pellucid.model import Vector, parameter
from pellucid.smooth_step import risen


class BodyForce(Load):
    """A force on every mass: an acceleration of one body, as of a frame that speeds up the other way."""

    kind: Literal["body-force"] = "body-force"
    acceleration: Vector = parameter("m/s^2", "force on unit mass")
    rise: float = parameter("s", "time over which it rises smoothly from zero", 0.0, ge=0)

    def forces(self, points: PointsView, time: float) -> np.ndarray:
        """Forces [N], shape (n, 3)."""
        return points.mass[:, None] * (risen(time, self.rise) * np.array(self.acceleration))
