"""Pressure that follows a membrane."""

from pellucid.conditions.signals import smooth_step
from pellucid.model import Model, parameter


class Pressure(Model):
    """A pressure difference on a membrane, along its normal wherever that points."""

    body: str = parameter("", "name of a membrane")
    value: float = parameter("Pa", "pressure behind the membrane minus that before it: it pushes along the normal")
    rise: float = parameter("s", "time over which it rises smoothly from zero", 0.0, ge=0)

    def at(self, time: float) -> float:
        """Pressure [Pa] at a time [s]."""
        return self.value * (smooth_step(time / self.rise) if self.rise > 0.0 else 1.0)
