"""The volume and the area that a film is to keep or to reach."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pellucid.findings import Finding, Path
from pellucid.model import Model, parameter
from pellucid.smooth_step import risen


class VolumeCase(Model):
    """The volume inside a film, which it keeps, or brings to another."""

    reduced: float | None = parameter(
        "", "reduced volume to reach, that of a sphere of the same area being 1; without it the volume is kept", None, gt=0
    )
    over: float = parameter("s", "time over which it changes smoothly from the volume at the start", 0.0, ge=0)

    def problems(self, path: Path) -> Iterator[Finding]:
        """More than a sphere holds."""
        if self.reduced is not None and self.reduced > 1.0:
            text = f"{self.reduced:g} is impossible: no surface holds more than a sphere of its area, which is 1"
            yield Finding((*path, "reduced"), text, "use a reduced volume below 1")


class Goals(NamedTuple):
    """What volume [m³] and area [m²] go to; None where they are free."""

    start: float
    volume: float | None
    over: float
    area: float | None

    def at(self, time: float) -> tuple[float | None, float | None]:
        """Volume and area at a time [s]."""
        volume = None if self.volume is None else self.start + (self.volume - self.start) * risen(time, self.over)
        return volume, self.area


def reduced_to_volume(reduced: float, area: float, plane: bool) -> float:
    """The volume [m³] of a reduced volume at an area [m²]; of a plane curve, 1 m deep, that of a circle of its length is 1."""
    return reduced * area**2 / (4.0 * np.pi) if plane else reduced * area**1.5 / (6.0 * np.sqrt(np.pi))
