"""Pressure that follows a membrane."""

from collections.abc import Iterator

from pellucid.conditions.signals import smooth_step
from pellucid.findings import Finding, Path
from pellucid.model import parameter
from pellucid.parts import Condition, Parts


class Pressure(Condition):
    """A pressure difference on a membrane, along its normal wherever that points."""

    body: str = parameter("", "name of a membrane")
    value: float = parameter("Pa", "pressure behind the membrane minus that before it: it pushes along the normal")
    rise: float = parameter("s", "time over which it rises smoothly from zero", 0.0, ge=0)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A body that is not there or has no normal."""
        yield from parts.unknown_body((*path, "body"), self.body)
        body = parts.body(self.body)
        if body is not None and not body.is_surface:
            text = f"body {self.body} is no membrane: it has no normal to push along"
            yield Finding((*path, "body"), text, "name a body of kind membrane-points or membrane-elements")

    def at(self, time: float) -> float:
        """Pressure [Pa] at a time [s]."""
        return self.value * (smooth_step(time / self.rise) if self.rise > 0.0 else 1.0)
