"""Hardy's multiquadric."""

from typing import Literal

import numpy as np

from pellucid.approximants.radial.contract import Profile, ShapedModel


class MultiquadricModel(ShapedModel):
    """Radial function φ = √(1 + (εr)²) of the distance r, with the shape parameter ε (Hardy 1971)."""

    kind: Literal["multiquadric"] = "multiquadric"

    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        e = shape * shape
        value = np.sqrt(1.0 + e * square)
        return Profile(value, 0.5 * e / value, -0.25 * e * e / value**3)

    @property
    def least_degree(self) -> int:
        """Smallest degree of the added polynomials: 0, as the function is conditionally definite of order 1."""
        return 0
