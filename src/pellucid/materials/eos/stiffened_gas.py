"""Stiffened gas, P = Γ ρ e - (Γ+1) P∞, with the specific internal energy e and the parameters Γ and P∞. Source: Gan et al.
2011, eq. 37."""

from math import sqrt
from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.eos.equation import EquationOfStateModel, any_tension, lowest_pressure, pressure_line, sound_speed
from pellucid.model import parameter


class StiffenedGas(NamedTuple):
    """Parameters of the stiffened gas for kernels: Grüneisen exponent Γ and stiffness P∞ [Pa]."""

    Gamma: float
    p_inf: float


class StiffenedGasCase(EquationOfStateModel):
    """Stiffened gas, P = Γ ρ e - (Γ+1) P∞: liquids under shock."""

    kind: Literal["stiffened-gas"] = "stiffened-gas"
    gruneisen: float = parameter("", "Grüneisen exponent Γ", gt=0)
    p_infinity: float = parameter("Pa", "stiffness P∞", ge=0)

    def law(self, density: float, pressure: float) -> StiffenedGas:
        return StiffenedGas(self.gruneisen, self.p_infinity)


@point_function(pressure_line, StiffenedGas)
def _pressure_line(eos, density):
    return -(eos.Gamma + 1.0) * eos.p_inf, eos.Gamma * density


point_function(lowest_pressure, StiffenedGas)(any_tension)


@point_function(sound_speed, StiffenedGas)
def _sound_speed(eos, density, energy):
    pressure = eos.Gamma * density * energy - (eos.Gamma + 1.0) * eos.p_inf
    return sqrt(max((eos.Gamma + 1.0) * (pressure + eos.p_inf) / density, 0.0))
