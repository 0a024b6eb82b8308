"""Lipid films: compressible, viscous surface fluids with optional bending stiffness.

The surface pressure is a power of the density excess over the density at rest. All quantities refer to the surface: density
[kg/m²], pressure [N/m], viscosity [N s/m].
"""

from typing import Literal

import numpy as np

from pellucid.materials.contract import BodyMaterial
from pellucid.model import parameter

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(24)

THINNEST = 0.05  # smallest density of a film, relative to its rest density


class LipidFilm(BodyMaterial):
    """Lipid film with the surface pressure p = a sgn(ρ - ρ₀) |ρ - ρ₀|^c at the surface density ρ. Source: Benet 2015, eq.
    3.45, which holds only for ρ > ρ₀ or odd c."""

    density: float = parameter("kg/m^2", "surface density ρ₀ at zero surface pressure", gt=0)
    viscosity: float = parameter("N*s/m", "shear viscosity μ of the surface", gt=0)
    dilatational_viscosity: float = parameter("N*s/m", "second viscosity λ of the surface", 0.0, ge=0)
    bending_rigidity: float = parameter("J", "bending rigidity κ_c, with the energy (κ_c/2)(2H - c₀)² per unit area", 0.0, ge=0)
    spontaneous_curvature: float = parameter(
        "1/m", "spontaneous curvature c₀, the sum of the principal curvatures at rest; positive for a sphere", 0.0
    )
    kind: Literal["lipid-film"] = "lipid-film"
    stiffness: float = parameter("", "stiffness a: surface pressure [N/m] per excess of the density over ρ₀ [kg/m²]", gt=0)
    exponent: float = parameter("", "c", 1.0, ge=1, le=9)

    def wave_speeds(self) -> tuple[float, float]:
        """Return zero for both wave speeds: the inertia is neglected, so there are no waves."""
        return 0.0, 0.0

    def pressure(self, density: np.ndarray) -> np.ndarray:
        """Return the surface pressure p [N/m] at surface densities [kg/m²]."""
        excess = density - self.density
        return np.asarray(self.stiffness * np.sign(excess) * np.abs(excess) ** self.exponent)

    def pressure_slope(self, density: np.ndarray) -> np.ndarray:
        """Return the derivative of the surface pressure with respect to the surface density, dp/dρ = a c |ρ - ρ₀|^(c-1)
        [m²/s²], at surface densities ρ [kg/m²], with the stiffness a, the exponent c and the density ρ₀ at rest."""
        return np.asarray(self.stiffness * self.exponent * np.abs(density - self.density) ** (self.exponent - 1.0))

    def stored_energy(self, density: np.ndarray) -> np.ndarray:
        """Return the stored energy per unit mass [J/kg] at surface densities ρ [kg/m²], ∫ p(r)/r² dr over the density r from
        ρ₀ to ρ, by 24 Gauss points: exact to rounding for c = 1 within a factor 4 of ρ₀."""
        half = 0.5 * (density - self.density)
        r = self.density + half[..., None] * (1.0 + POINTS)
        return np.asarray(half * ((self.pressure(r) / (r * r)) @ WEIGHTS))
