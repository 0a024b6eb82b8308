"""Lipid films: the pressure is a power of what the density exceeds that of rest."""

from typing import Literal

import numpy as np

from pellucid.materials.film import FilmMaterial
from pellucid.model import parameter

POINTS, WEIGHTS = np.polynomial.legendre.leggauss(24)


class LipidFilm(FilmMaterial):
    """p = a sgn(ρ - ρ₀) |ρ - ρ₀|^c.   Source: Benet 2015, eq. 3.45, which is for ρ > ρ₀ or odd c alone."""

    kind: Literal["lipid-film"] = "lipid-film"
    stiffness: float = parameter("", "a, the pressure [N/m] where the density exceeds ρ₀ by 1 kg/m²", gt=0)
    exponent: float = parameter("", "c", 1.0, ge=1, le=9)

    def pressure(self, density: np.ndarray) -> np.ndarray:
        """p [N/m]."""
        excess = density - self.density
        return np.asarray(self.stiffness * np.sign(excess) * np.abs(excess) ** self.exponent)

    def pressure_slope(self, density: np.ndarray) -> np.ndarray:
        """a c |ρ - ρ₀|^(c-1)."""
        return np.asarray(self.stiffness * self.exponent * np.abs(density - self.density) ** (self.exponent - 1.0))

    def stored_energy(self, density: np.ndarray) -> np.ndarray:
        """∫ p/r² dr, by 24 Gauss points: exact to rounding for c = 1 within a factor 4 of ρ₀."""
        half = 0.5 * (density - self.density)
        r = self.density + half[..., None] * (1.0 + POINTS)
        return np.asarray(half * ((self.pressure(r) / (r * r)) @ WEIGHTS))
