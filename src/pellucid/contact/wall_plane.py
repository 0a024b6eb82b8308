"""Geometry of wall planes, without kernels, so that cases can describe walls without compilation."""

import numpy as np


class WallPlane:
    """Moving plane through a point [m]; the normal (of any length) points to the side of the bodies; velocity in [m/s]."""

    def __init__(
        self, point: tuple[float, float, float], normal: tuple[float, float, float], velocity: tuple[float, float, float]
    ) -> None:
        self._point, self._full_velocity = np.array(point, float), np.array(velocity, float)
        largest = np.abs(normal).max()  # so that no square of a component overflows or vanishes
        self.normal = np.array(normal, float) / largest
        self.normal /= np.linalg.norm(self.normal)
        self.go_to(0.0, 1.0)

    def go_to(self, time: float, rate: float) -> None:
        """Move the plane to its position at the load time `time` [s], at which prescribed motions are evaluated.

        rate: increment of the load time per increment of the step time; the velocity of the plane is 0 if the rate is 0.
        """
        self.velocity = rate * self._full_velocity if rate > 0.0 else np.zeros(3)
        self.level = float(np.sum(self.normal * (self._point + time * self._full_velocity)))

    def height(self, place: np.ndarray) -> np.ndarray:
        """Return the heights above the plane [m], shape (n,), of the positions `place` [m], shape (n, 3)."""
        return np.asarray(np.sum(place * self.normal, axis=1) - self.level)
