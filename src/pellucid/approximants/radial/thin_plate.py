"""Thin-plate splines."""

from typing import Literal

import numpy as np

from pellucid.approximants.radial.contract import Profile, RadialModel
from pellucid.model import parameter


class ThinPlateModel(RadialModel):
    """Radial function φ = r²ᵏ ln r of the distance r (Duchon 1977); second derivatives of r² ln r, the thin plate itself, are
    infinite at the nodes."""

    kind: Literal["thin-plate"] = "thin-plate"
    order: Literal[1, 2, 3] = parameter("", "exponent k in the radial function φ = r²ᵏ ln r of the distance r", 2)

    def profile(self, square: np.ndarray, shape: np.ndarray) -> Profile:
        """Return the radial function φ = r²ᵏ ln r = ½ sᵏ ln s of s = r² (`square`) and its first two derivatives by s;
        arguments: see `RadialModel.profile`."""
        k = self.order
        logarithm = np.log(np.where(square > 0.0, square, 1.0))  # at a node it is multiplied by zeros
        first = 0.5 * square ** (k - 1) * (k * logarithm + 1.0)
        # for k = 1 it is only used away from the nodes
        lower = square ** (k - 2) if k > 1 else 1.0 / np.where(square > 0.0, square, np.inf)
        return Profile(0.5 * square**k * logarithm, first, 0.5 * lower * (k * (k - 1) * logarithm + 2 * k - 1))

    @property
    def least_degree(self) -> int:
        """Smallest degree of the added polynomials: k, as the function r²ᵏ ln r is conditionally definite of order k + 1."""
        return self.order

    @property
    def derivatives(self) -> int:
        return 2 * self.order - 1
