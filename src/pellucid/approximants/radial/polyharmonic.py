"""Polyharmonic splines with odd powers."""

from typing import Literal

import numpy as np

from pellucid.approximants.radial.contract import Profile, RadialModel
from pellucid.model import parameter


class PolyharmonicModel(RadialModel):
    """Radial function φ = r³, r⁵ or r⁷ of the distance r (Duchon 1977), without a length parameter."""

    kind: Literal["polyharmonic"] = "polyharmonic"
    power: Literal[3, 5, 7] = parameter("", "power p in the radial function φ = rᵖ of the distance r", 5)

    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        half = 0.5 * self.power
        root = np.sqrt(square)
        inverse = 1.0 / np.where(root > 0.0, root, np.inf)  # for r³; at a node it is only multiplied by zeros
        lowest = {3: inverse, 5: root, 7: square * root}[self.power]
        return Profile(square * square * lowest, half * square * lowest, half * (half - 1.0) * lowest)

    @property
    def least_degree(self) -> int:
        """Smallest degree of the added polynomials for the power p: (p - 1)/2, as the function is conditionally definite of
        order ⌈p/2⌉."""
        return (self.power - 1) // 2

    @property
    def derivatives(self) -> int:
        return self.power - 1
