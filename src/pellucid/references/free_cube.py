"""A neo-Hookean cube that is pressed or pulled along z between smooth plates, its sides free: uniform strain, exact.

The stretch across follows from no stress across, ∂Ψ/∂λ = 0, for either form: Ψ = μ/2 (I₁-3) - μ ln J + λ/2 ln² J, and
Ψ = μ/2 (J^(-2/3) I₁-3) + κ/2 (J-1)².
"""

from math import log
from typing import NamedTuple

from scipy.optimize import brentq


class FreeCube(NamedTuple):
    """Young's modulus [Pa], Poisson's ratio, and which form: coupled, or decoupled into shape and volume."""

    young_modulus: float
    poisson_ratio: float
    decoupled: bool = False

    def energy(self, along: float, across: float) -> float:
        """Of unit volume [Pa] at stretches along z and across."""
        E, nu = self.young_modulus, self.poisson_ratio
        mu, J, trace = 0.5 * E / (1.0 + nu), across * across * along, 2.0 * across * across + along * along
        if self.decoupled:
            return 0.5 * mu * (J ** (-2.0 / 3.0) * trace - 3.0) + E / (6.0 * (1.0 - 2.0 * nu)) * (J - 1.0) ** 2
        lame = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
        return 0.5 * mu * (trace - 3.0) - mu * log(J) + 0.5 * lame * log(J) ** 2

    def slopes(self, along: float, across: float) -> tuple[float, float]:
        """Derivatives of the energy by the stretches along z and across [Pa]."""
        E, nu = self.young_modulus, self.poisson_ratio
        mu, J, trace = 0.5 * E / (1.0 + nu), across * across * along, 2.0 * across * across + along * along
        if self.decoupled:
            share, bulk = mu * J ** (-2.0 / 3.0), E / (3.0 * (1.0 - 2.0 * nu)) * (J - 1.0)
            return share * (along - trace / (3.0 * along)) + bulk * J / along, 2.0 * (
                share * (across - trace / (3.0 * across)) + bulk * J / across
            )
        lame = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
        rest = lame * log(J) - mu
        return mu * along + rest / along, 2.0 * (mu * across + rest / across)

    def across(self, along: float) -> float:
        """The stretch across at a stretch along z."""
        return float(brentq(lambda stretch: self.slopes(along, stretch)[1], 0.2, 5.0, xtol=1e-15, rtol=1e-14))

    def stress(self, along: float) -> float:
        """Force on unit area at rest along z [Pa]."""
        return self.slopes(along, self.across(along))[0]
