"""A shape that is moved: the image of one across a seam of a periodic grid."""

import numpy as np

from pellucid.geometry.shapes.contract import ActiveAxes, Geometry
from pellucid.model import Vector, parameter


class Shifted(Geometry):
    """A shape moved along axes."""

    shape: Geometry = parameter("", "what is moved")
    by: Vector = parameter("m", "how far")

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Those of the shape, moved."""
        lower, upper = self.shape.bounds()
        return lower + self.by, upper + self.by

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        """Which points lie in the shape when moved back."""
        return self.shape.contains(points - np.array(self.by), active)

    def measure(self, active: ActiveAxes) -> float:
        """That of the shape."""
        return self.shape.measure(active)

    def centre(self) -> np.ndarray:
        """Where the shape's centre comes to [m], shape (3,)."""
        return self.shape.centre() + np.array(self.by)
