"""The interface of materials of fluid films: a pressure that follows from the density, viscosity within the surface, bending.

Everything is taken in the surface: density [kg/m²], pressure [N/m], viscosity [N s/m].
"""

from abc import abstractmethod

import numpy as np

from pellucid.materials.contract import BodyMaterial
from pellucid.model import parameter
from pellucid.registry import Family


class FilmMaterial(BodyMaterial):
    """A compressible, viscous fluid in a surface, which may resist bending. A new one is a subclass with its own `kind`."""

    density: float = parameter("kg/m^2", "density in the surface at which it has no pressure, ρ₀", gt=0)
    viscosity: float = parameter("N*s/m", "shear viscosity μ of the surface", gt=0)
    dilatational_viscosity: float = parameter("N*s/m", "second viscosity λ of the surface", 0.0, ge=0)
    bending_rigidity: float = parameter("J", "κ_c of the bending energy (κ_c/2)(2H - c₀)² of unit area", 0.0, ge=0)
    spontaneous_curvature: float = parameter(
        "1/m", "c₀, the sum of the principal curvatures at rest; positive as of a sphere", 0.0
    )

    @abstractmethod
    def pressure(self, density: np.ndarray) -> np.ndarray:
        """Pressure in the surface [N/m] at densities [kg/m²], of any shape; negative where the film is under tension."""

    @abstractmethod
    def pressure_slope(self, density: np.ndarray) -> np.ndarray:
        """dp/dρ [N m/kg], not negative."""

    @abstractmethod
    def stored_energy(self, density: np.ndarray) -> np.ndarray:
        """Energy of unit mass [J/kg], e = ∫ p/r² dr from the density of rest: so that d(m e) = -p dA."""

    def wave_speeds(self) -> tuple[float, float]:
        """Its inertia is left out: no wave crosses it."""
        return 0.0, 0.0


FILM_MATERIALS = Family("material", FilmMaterial, default="lipid-film")
"""The kinds that a case can name."""
