"""Initial field: a velocity that varies linearly in space, such as a simple shear."""

from typing import Literal

import numpy as np

from pellucid.bodies.initial.contract import InitialField
from pellucid.model import Vector, parameter

NONE = (0.0, 0.0, 0.0)


class VelocityGradient(InitialField):
    """An initial velocity L (x - x₀) at positions x, with the velocity gradient L and the point x₀ at rest."""

    kind: Literal["velocity-gradient"] = "velocity-gradient"
    x: Vector = parameter("1/s", "gradient of the x velocity component, the first row of L", NONE)
    y: Vector = parameter("1/s", "gradient of the y velocity component", NONE)
    z: Vector = parameter("1/s", "gradient of the z velocity component", NONE)
    origin: Vector = parameter("m", "position x₀ of zero velocity", NONE)

    def at(self, position: np.ndarray) -> np.ndarray:
        return np.asarray((position - np.array(self.origin)) @ np.array((self.x, self.y, self.z)).T)
