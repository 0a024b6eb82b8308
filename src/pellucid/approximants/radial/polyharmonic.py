"""Polyharmonic splines of odd powers."""

from typing import Literal

import numpy as np

from pellucid.approximants.radial.contract import Profile, RadialModel
from pellucid.model import parameter


class PolyharmonicModel(RadialModel):
    """φ = r³, r⁵ or r⁷ (Duchon 1977); without a parameter of length."""

    kind: Literal["polyharmonic"] = "polyharmonic"
    power: Literal[3, 5, 7] = parameter("", "power p of the distance", 5)

    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        """φ = s^(p/2)."""
        half = 0.5 * self.power
        root = np.sqrt(square)
        inverse = 1.0 / np.where(root > 0.0, root, np.inf)  # of r³, at a node only its product with zeros counts
        lowest = {3: inverse, 5: root, 7: square * root}[self.power]
        return Profile(square * square * lowest, half * square * lowest, half * (half - 1.0) * lowest)

    @property
    def least_degree(self) -> int:
        """It is conditionally definite of order ⌈power/2⌉."""
        return (self.power - 1) // 2

    @property
    def derivatives(self) -> int:
        """One less than the power."""
        return self.power - 1
