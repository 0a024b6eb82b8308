"""Pressure that follows a membrane."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

from pellucid.conditions.smooth_step import smooth_step
from pellucid.findings import Finding, Path
from pellucid.model import parameter
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts

if TYPE_CHECKING:
    from pellucid.parts.assembly import Assembly


class Pressure(Condition):
    """A pressure difference on a membrane, along its normal wherever that points."""

    body: str = parameter("", "name of a membrane")
    value: float = parameter("Pa", "pressure behind the membrane minus that before it: it pushes along the normal")
    rise: float = parameter("s", "time over which it rises smoothly from zero", 0.0, ge=0)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A body that is not there or has no normal."""
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        body = parts.named(BodyModel, self.body)
        if body is not None and not body.is_surface:
            text = f"body {self.body} is no membrane: it has no normal to push along"
            yield Finding((*path, "body"), text, "name a body of kind membrane-points or membrane-elements")

    def load_channel(self) -> str:
        """Shared with other loads."""
        return "load_work"

    @classmethod
    def activate(cls, conditions: Sequence["Pressure"], assembly: "Assembly") -> Sequence["ActivePressure"]:
        """One for each."""
        return [ActivePressure(pressure, assembly) for pressure in conditions]

    def at(self, time: float) -> float:
        """Pressure [Pa] at a time [s]."""
        return self.value * (smooth_step(time / self.rise) if self.rise > 0.0 else 1.0)


class ActivePressure(ActiveCondition):
    """A pressure on a membrane that is built."""

    def __init__(self, pressure: Pressure, assembly: "Assembly") -> None:
        self._body, self._pressure = assembly.bodies[pressure.body].body, pressure
        self._column = assembly.load_column(pressure.body, pressure.load_channel())

    def begin(self, time: float, dt: float) -> None:
        """Its forces over the step."""
        self._body.add_pressure(self._pressure.at(time), self._column)
