"""An acceleration of one body."""

from typing import Literal

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.loads.contract import Load, PointsView
from pellucid.model import Vector, parameter


class BodyForce(ChangesInTime, Load):
    """A force on every mass: an acceleration of one body, as of a frame that speeds up the other way."""

    kind: Literal["body-force"] = "body-force"
    acceleration: Vector = parameter("m/s^2", "force on unit mass")

    def forces(self, points: PointsView, time: float) -> np.ndarray:
        """Forces [N], shape (n, 3)."""
        return points.mass[:, None] * (self.share(time) * np.array(self.acceleration))
