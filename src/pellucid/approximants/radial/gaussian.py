"""Gaussians, the functions of the thesis."""

from typing import Literal

import numpy as np

from pellucid.approximants.radial.contract import Profile, ShapedModel


class GaussianModel(ShapedModel):
    """φ = exp(-(εr)²) (Benet 2015, eq. 4.16)."""

    kind: Literal["gaussian"] = "gaussian"

    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        """φ = exp(-ε² s)."""
        e = shape * shape
        value = np.exp(-e * square)
        return Profile(value, -e * value, e * e * value)

    @property
    def least_degree(self) -> int:
        """It is positive definite and needs none."""
        return -1
