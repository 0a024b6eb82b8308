"""Signal (a prescribed displacement as a function of time): a sine."""

from math import pi, sin
from typing import Literal

from pellucid.conditions.signals.contract import Displacement, SignalModel
from pellucid.model import parameter


class Sine(SignalModel):
    """A sine with amplitude a, period T and phase φ that starts at 0: u = a (sin(2π t/T + φ) - sin φ)."""

    kind: Literal["sine"] = "sine"
    amplitude: float = parameter("m", "amplitude a")
    period: float = parameter("s", "period T", gt=0)
    phase: float = parameter("rad", "phase φ", 0.0)

    def function(self) -> Displacement:
        return lambda t: self.amplitude * (sin(2.0 * pi * t / self.period + self.phase) - sin(self.phase))

    def top_speed(self) -> float:
        return abs(self.amplitude) * 2.0 * pi / self.period
