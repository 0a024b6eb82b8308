"""Tait's liquid, P = P₀ + ρ₀ c₀²/n [(ρ/ρ₀)ⁿ - 1], with the initial pressure P₀, density ρ₀ and sound speed c₀; the pressure
does not depend on the energy."""

from math import inf, sqrt
from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.jit.elementary import power
from pellucid.materials.eos.equation import EquationOfStateModel, limited_tension, lowest_pressure, pressure_line, sound_speed
from pellucid.model import parameter


class Tait(NamedTuple):
    """Parameters of Tait's equation for kernels: density ρ₀ [kg/m³], pressure P₀ [Pa] and sound speed c₀ [m/s] of the
    initial state, exponent n, and smallest pressure [Pa]."""

    rho0: float
    p0: float
    c0: float
    n: float
    p_min: float


class TaitCase(EquationOfStateModel):
    """Tait's liquid, P = P₀ + ρ₀ c₀²/n [(ρ/ρ₀)ⁿ - 1], about the initial density and pressure."""

    kind: Literal["tait"] = "tait"
    sound_speed: float = parameter("m/s", "sound speed c₀ at the initial state", gt=0)
    exponent: float = parameter("", "exponent n", 7.0, ge=1)
    carries_tension: bool = parameter("", "true: the pressure may become negative; with a free surface use false", False)

    def law(self, density: float, pressure: float) -> Tait:
        return Tait(density, pressure, self.sound_speed, self.exponent, -inf if self.carries_tension else 0.0)


@point_function(pressure_line, Tait)
def _pressure_line(eos, density):
    stiffness = eos.rho0 * eos.c0 * eos.c0 / eos.n
    ratio = density / eos.rho0
    return eos.p0 + stiffness * (ratio * power(ratio, eos.n - 1.0) - 1.0), 0.0  # the power that the sound speed takes too


point_function(lowest_pressure, Tait)(limited_tension)


@point_function(sound_speed, Tait)
def _sound_speed(eos, density, energy):
    return eos.c0 * sqrt(power(density / eos.rho0, eos.n - 1.0))
