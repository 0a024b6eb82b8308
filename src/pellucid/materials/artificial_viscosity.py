"""Artificial viscosity that spreads a shock over a few cells. Source: Gan et al. 2011, eq. 32."""

from typing import NamedTuple

from pellucid.jit import pointwise
from pellucid.model import Model, parameter


class ArtificialViscosity(NamedTuple):
    """Parameters of the artificial pressure q = ρ l (c₀ l (tr D)² - c₁ a tr D) in compression, 0 in expansion, with the
    density ρ, the cell size l, the sound speed a and the rate of deformation D. Fields: c₀ (`quadratic`), c₁ (`linear`),
    and `work`, which is 1 if q heats the fluid, else 0."""

    quadratic: float
    linear: float
    work: float


class ArtificialViscosityCase(Model):
    """Artificial viscosity in a case file."""

    quadratic: float = parameter("", "coefficient c₀ of the quadratic term of the artificial viscous pressure q", 0.0, ge=0)
    linear: float = parameter("", "coefficient c₁ of the linear term of the artificial viscous pressure q", 0.0, ge=0)
    work: bool = parameter("", "true: q does work in the energy equation; false: this energy is lost in shocks", True)

    def law(self) -> ArtificialViscosity:
        return ArtificialViscosity(self.quadratic, self.linear, 1.0 if self.work else 0.0)


@pointwise
def artificial_pressure(av: ArtificialViscosity, density: float, a: float, trD: float, length: float) -> float:
    """Return the artificial pressure q [Pa] in compression, 0 in expansion (see `ArtificialViscosity`). density [kg/m³]; a:
    sound speed [m/s]; trD: volume rate tr D [1/s]; av: coefficients of the artificial viscosity; length: cell size [m]."""
    if trD >= 0.0:
        return 0.0
    return density * length * (av.quadratic * length * trD * trD - av.linear * a * trD)


@pointwise
def artificial_speed(av: ArtificialViscosity, a: float, trD: float, length: float) -> float:
    """Return the contribution Q = c₁ a + c₀ l |tr D| of artificial viscosity to the signal speed [m/s]; the signal speed
    becomes Q + sqrt(Q² + a²) (Hallquist, LS-DYNA theory manual). av: coefficients c₀ and c₁; a: sound speed [m/s]; trD:
    volume rate tr D [1/s]; length: cell size l [m]."""
    if trD >= 0.0:
        return 0.0
    return av.linear * a - av.quadratic * length * trD
