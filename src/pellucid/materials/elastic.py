"""Base class of isotropic elastic materials, with their parameters: density, Young's modulus, Poisson's ratio."""

from math import sqrt

from pellucid.model import Model, parameter


def lame(young_modulus: float, poisson_ratio: float) -> tuple[float, float]:
    """Return Lamé's constants λ and μ [Pa] for Young's modulus [Pa] and Poisson's ratio."""
    mu = young_modulus / (2.0 * (1.0 + poisson_ratio))
    return 2.0 * mu * poisson_ratio / (1.0 - 2.0 * poisson_ratio), mu


class ElasticMaterial(Model):
    """Base of isotropic elastic solids and membranes."""

    density: float = parameter("kg/m^3", "initial density", gt=0)
    young_modulus: float = parameter("Pa", "Young's modulus E", gt=0)
    poisson_ratio: float = parameter("", "Poisson's ratio ν", gt=-1, lt=0.5)

    def wave_speeds(self) -> tuple[float, float]:
        """Return the speeds of plane pressure and shear waves in the initial state [m/s]."""
        lam, mu = lame(self.young_modulus, self.poisson_ratio)
        return sqrt((lam + 2.0 * mu) / self.density), sqrt(mu / self.density)
