"""Signal (a prescribed displacement as a function of time): a constant velocity."""

from typing import Literal

from pellucid.conditions.signals.contract import Displacement, SignalModel
from pellucid.model import parameter


class Steady(SignalModel):
    """A motion at constant velocity v: displacement u = v t."""

    kind: Literal["steady"] = "steady"
    velocity: float = parameter("m/s", "velocity v")

    def function(self) -> Displacement:
        return lambda t: self.velocity * t

    def top_speed(self) -> float:
        return abs(self.velocity)
