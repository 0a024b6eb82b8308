"""Signal (a prescribed displacement as a function of time): a smooth ramp."""

from typing import Literal

from pellucid.conditions.signals.contract import Displacement, SignalModel
from pellucid.model import parameter
from pellucid.smooth_step import smooth_step


class Ramp(SignalModel):
    """A smooth ramp from 0 to the displacement d, u = d s³(10 - 15 s + 6 s²) with s = (t - t₀)/T, for the start time t₀
    and the duration T."""

    kind: Literal["ramp"] = "ramp"
    distance: float = parameter("m", "final displacement d")
    duration: float = parameter("s", "duration T", gt=0)
    start: float = parameter("s", "start time t₀", 0.0, ge=0)

    def function(self) -> Displacement:
        return lambda t: self.distance * smooth_step((t - self.start) / self.duration)

    def top_speed(self) -> float:
        return 1.875 * abs(self.distance) / self.duration
