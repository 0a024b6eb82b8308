"""Planes that surfaces touch, by their places alone: cases describe them without kernels."""

import numpy as np


class WallPlane:
    """A plane through a point [m] with a normal of any length, to the side where bodies are, that moves at a velocity [m/s]."""

    def __init__(
        self, point: tuple[float, float, float], normal: tuple[float, float, float], velocity: tuple[float, float, float]
    ) -> None:
        self._point, self._full_velocity = np.array(point, float), np.array(velocity, float)
        largest = np.abs(normal).max()  # so that no square of a component overflows or vanishes
        self.normal = np.array(normal, float) / largest
        self.normal /= np.linalg.norm(self.normal)
        self.go_to(0.0, 1.0)

    def go_to(self, time: float, rate: float) -> None:
        """Be where it is at a time of the loads [s], which grows by this rate in that of the steps: at rest where it is 0."""
        self.velocity = rate * self._full_velocity if rate > 0.0 else np.zeros(3)
        self.level = float(np.sum(self.normal * (self._point + time * self._full_velocity)))

    def height(self, place: np.ndarray) -> np.ndarray:
        """Return the heights of positions [m], shape (n, 3), above the plane [m], shape (n,)."""
        return np.asarray(np.sum(place * self.normal, axis=1) - self.level)
