"""Constraints of the volume and area of a film: constant or changed to a prescribed value."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pellucid.findings import Finding, Path
from pellucid.model import Model, parameter
from pellucid.smooth_step import risen

FULLEST = 0.999
"""Largest reduced volume that can be prescribed. At 1 the film is a sphere: constant volume and area allow no motion, and the
equations for the velocity are singular. Curves and meridians with 8 nodes and surfaces with 42 nodes reach 0.999."""


class VolumeCase(Model):
    """The volume inside a film: kept constant or changed to a prescribed reduced volume."""

    reduced: float | None = parameter(
        "", "target reduced volume; 1 for a sphere of the same area; default: the volume is constant", None, gt=0
    )
    over: float | None = parameter(
        "s", "duration of the smooth change from the initial volume; required with `reduced`", None, gt=0
    )

    def problems(self, path: Path, plane: bool, keeps_area: bool) -> Iterator[Finding]:
        """Yield findings (errors of the case) for a reduced volume above 1 (the value of a sphere or circle), a change of
        volume without a duration, and a change of volume if the area is free.

        path: path of the film in the data of the case; plane: True for a curve in a plane; keeps_area: True if the area is
        constant.
        """
        if self.reduced is None:
            if self.over is not None:
                yield Finding((*path, "over"), "`over` applies to a changing volume", "add `reduced`, or remove `over`")
            return
        if self.reduced > FULLEST:
            curve, full, of = ("curve", "circle", "length") if plane else ("surface", "sphere", "area")
            if self.reduced > 1.0:
                text = f"{self.reduced:g} is impossible: no {curve} encloses more than a {full} of the same {of}, which has 1"
            else:
                text = f"{self.reduced:g} is above {FULLEST:g}: a {full}, which has 1, cannot move at constant volume and {of}"
            remedy = f"use at most {FULLEST:g}; for a {full}, use a {full} as `shape` and remove `volume` and `area`"
            yield Finding((*path, "reduced"), text, remedy)
        if self.over is None:
            text = "an instantaneous change of volume would need an infinite velocity"
            yield Finding(path, text, "add `over = ...`, the duration of the change, such as the relaxation time of the film")
        if not keeps_area:
            text = "a reduced volume refers to a fixed area, but the area of this film is free and would change"
            yield Finding((*path, "reduced"), text, 'add area = "kept"')


class Goals(NamedTuple):
    """Prescribed volume and area of a film over time.

    Attributes: start, volume: initial and final enclosed volume [m³]; over: duration of the change [s]; area: constant area
    [m²]. None if volume or area are free.
    """

    start: float
    volume: float | None
    over: float
    area: float | None

    def at(self, time: float) -> tuple[float | None, float | None]:
        """Return the prescribed volume [m³] and area [m²] at a time [s]; None if free."""
        volume = None if self.volume is None else self.start + (self.volume - self.start) * risen(time, self.over)
        return volume, self.area


def reduced_to_volume(reduced: float, area: float, plane: bool) -> float:
    """Return the enclosed volume [m³] of a film from its reduced volume, which is 1 for a sphere (for a circle if the film is
    a plane curve of depth 1 m), and from its area [m²]. plane: True for a plane curve.
    """
    return reduced * area**2 / (4.0 * np.pi) if plane else reduced * area**1.5 / (6.0 * np.sqrt(np.pi))
