"""Gaussian radial functions."""

from typing import Literal

import numpy as np

from pellucid.approximants.radial.contract import Profile, ShapedModel


class GaussianModel(ShapedModel):
    """Radial function φ = exp(-(εr)²) of the distance r, with the shape parameter ε (Benet 2015, eq. 4.16)."""

    kind: Literal["gaussian"] = "gaussian"

    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        e = shape * shape
        value = np.exp(-e * square)
        return Profile(value, -e * value, e * e * value)

    @property
    def least_degree(self) -> int:
        """Smallest degree of the added polynomials: -1, i.e. none are needed, as the function is positive definite."""
        return -1
