"""A translated shape: its image across a periodic boundary of the grid."""

import numpy as np

from pellucid.geometry.shapes.contract import ActiveAxes, Geometry
from pellucid.model import Vector, parameter


class Shifted(Geometry):
    """A shape translated by a vector."""

    shape: Geometry = parameter("", "shape that is translated")
    by: Vector = parameter("m", "translation")

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        lower, upper = self.shape.bounds()
        return lower + self.by, upper + self.by

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        return self.shape.contains(points - np.array(self.by), active)

    def measure(self, active: ActiveAxes) -> float:
        return self.shape.measure(active)

    def centre(self) -> np.ndarray:
        return self.shape.centre() + np.array(self.by)
