"""Column of a compressible neo-Hookean solid between smooth walls, compressed by its own weight.

At the height Y of the stress-free column the nominal stress supports the weight above, P(λ) = -ρ₀ g (H - Y), and with
uniaxial strain P = μ (λ - 1/λ) + Λ ln λ/λ. P is also the Cauchy stress because the cross-section is constant. The deformed
heights are y = ∫λ dY.
Source: Bonet & Wood 2008, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed., eq. 6.28, for the law.
"""

from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from pellucid.references.annotations import Array, Case

HEIGHTS = 2001  # at which the stretch is found; Simpson's rule between them is exact to 1e-12


@dataclass(frozen=True)
class HeavyColumn:
    """A column between smooth walls that is compressed by its own weight, the reference of a case: height [m], density
    [kg/m³], gravity [m/s²] and Lamé's constants [Pa]."""

    height: float  # H, stress-free height [m]
    density: float  # ρ₀ [kg/m³]
    gravity: float  # g [m/s²]
    first: float  # Lamé's constant λ [Pa]
    shear: float  # Lamé's constant μ [Pa]

    @classmethod
    def of(cls, case: Case) -> "HeavyColumn":
        """Build the column of a case whose first body is a box on the lower face of the grid, with gravity along -y."""
        body = case.body[0]
        lower, upper = body.bounds()
        material = cast(Any, body.material)
        young, poisson = material.young_modulus, material.poisson_ratio
        shear = young / (2.0 * (1.0 + poisson))
        first = young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson))
        return cls(float(upper[1] - lower[1]), material.density, -case.gravity[1], first, shear)

    def stress(self, heights: Array) -> Array:
        """Return the axial stress [Pa] at heights in the stress-free column [m] of any shape."""
        return np.asarray(-self.density * self.gravity * (self.height - heights))

    def stretch(self, heights: Array) -> Array:
        """Return the axial stretch λ at heights in the stress-free column [m] of any shape, by bisection."""
        wanted = self.stress(heights)
        low, high = np.full(wanted.shape, 1e-6), np.ones(wanted.shape)
        for _ in range(60):
            middle = 0.5 * (low + high)
            below = self.shear * (middle - 1.0 / middle) + self.first * np.log(middle) / middle < wanted
            low, high = np.where(below, middle, low), np.where(below, high, middle)
        return 0.5 * (low + high)

    def place(self, heights: Array) -> Array:
        """Return the heights in the compressed column [m] for heights in the stress-free column [m] of any shape."""
        from scipy.integrate import cumulative_simpson

        line = np.linspace(0.0, self.height, HEIGHTS)
        return np.asarray(np.interp(heights, line, cumulative_simpson(self.stretch(line), x=line, initial=0.0)))
