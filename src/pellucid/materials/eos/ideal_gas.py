"""Ideal gas, P = (γ-1) ρ e, with the specific internal energy e."""

from math import sqrt
from typing import Literal, NamedTuple

from pellucid.jit import point_function
from pellucid.materials.eos.equation import EquationOfStateModel, any_tension, lowest_pressure, pressure_line, sound_speed
from pellucid.model import parameter


class IdealGas(NamedTuple):
    """Parameter of the ideal gas for kernels: ratio γ of specific heats."""

    gamma: float


class IdealGasCase(EquationOfStateModel):
    """Ideal gas, P = (γ-1) ρ e."""

    kind: Literal["ideal-gas"] = "ideal-gas"
    gamma: float = parameter("", "ratio of specific heats γ", gt=1)

    def law(self, density: float, pressure: float) -> IdealGas:
        return IdealGas(self.gamma)


@point_function(pressure_line, IdealGas)
def _pressure_line(eos, density):
    return 0.0, (eos.gamma - 1.0) * density


point_function(lowest_pressure, IdealGas)(any_tension)


@point_function(sound_speed, IdealGas)
def _sound_speed(eos, density, energy):
    return sqrt(eos.gamma * (eos.gamma - 1.0) * max(energy, 0.0))
