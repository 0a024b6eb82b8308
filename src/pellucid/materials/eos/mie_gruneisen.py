"""Mie–Grüneisen with a linear shock Hugoniot, U = c₀ + s u, for the shock speed U and the particle speed u.

P = p_H (1 - γμ/2) + γ₀ρ₀ e with μ = ρ/ρ₀ - 1, p_H = ρ₀c₀² μ(1+μ)/[1-(s-1)μ]² in compression and ρ₀c₀² μ in expansion, γ =
γ₀ρ₀/ρ. Source: Lian et al. 2014, eq. 66.
"""

from math import inf, sqrt
from typing import Literal, NamedTuple

from pellucid.jit import point_function, pointwise
from pellucid.materials.eos.equation import EquationOfStateModel, limited_tension, lowest_pressure, pressure_line, sound_speed
from pellucid.model import parameter


class MieGruneisen(NamedTuple):
    """Parameters of the Mie–Grüneisen equation for kernels: initial density ρ₀ [kg/m³], shock speed c₀ at zero particle
    speed [m/s], slope s of the Hugoniot, Grüneisen coefficient γ₀, and smallest pressure [Pa]."""

    rho0: float
    c0: float
    s: float
    gamma0: float
    p_min: float


class MieGruneisenCase(EquationOfStateModel):
    """Mie–Grüneisen with a linear shock Hugoniot about the initial density."""

    kind: Literal["mie-gruneisen"] = "mie-gruneisen"
    sound_speed: float = parameter("m/s", "c₀, the shock speed at zero particle speed", gt=0)
    slope: float = parameter("", "slope s of shock speed versus particle speed", ge=0)
    gruneisen: float = parameter("", "Grüneisen coefficient γ₀", ge=0)
    carries_tension: bool = parameter("", "true: the pressure may become negative", False)

    def law(self, density: float, pressure: float) -> MieGruneisen:
        limit = -inf if self.carries_tension else 0.0
        return MieGruneisen(density, self.sound_speed, self.slope, self.gruneisen, limit)


@pointwise
def _cold_line(eos, density):
    """Return A(ρ) [Pa], i.e. the pressure P = A + B e at zero specific energy e, and its derivative dA/dρ [m²/s²], at a
    density ρ [kg/m³]."""
    mu = density / eos.rho0 - 1.0
    stiffness = eos.rho0 * eos.c0 * eos.c0
    if mu <= 0.0:
        return stiffness * mu, stiffness / eos.rho0
    room = 1.0 - (eos.s - 1.0) * mu
    hugoniot = stiffness * mu * (1.0 + mu) / (room * room)
    slope = stiffness * ((1.0 + 2.0 * mu) * room + 2.0 * (eos.s - 1.0) * mu * (1.0 + mu)) / (room * room * room)
    # γμ/2 with γ = γ₀/(1+μ)
    half = 0.5 * eos.gamma0 * mu / (1.0 + mu)
    half_slope = 0.5 * eos.gamma0 / ((1.0 + mu) * (1.0 + mu))
    return hugoniot * (1.0 - half), (slope * (1.0 - half) - hugoniot * half_slope) / eos.rho0


@point_function(pressure_line, MieGruneisen)
def _pressure_line(eos, density):
    return _cold_line(eos, density)[0], eos.gamma0 * eos.rho0


point_function(lowest_pressure, MieGruneisen)(limited_tension)


@point_function(sound_speed, MieGruneisen)
def _sound_speed(eos, density, energy):
    cold, slope = _cold_line(eos, density)
    pressure = cold + eos.gamma0 * eos.rho0 * energy
    # c² = ∂P/∂ρ + P/ρ² ∂P/∂e
    return sqrt(max(slope + pressure * eos.gamma0 * eos.rho0 / (density * density), 0.0))
