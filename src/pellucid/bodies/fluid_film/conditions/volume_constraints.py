"""Constraints of volume and area: what a film is to keep or to reach."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pellucid.findings import Finding, Path
from pellucid.model import Model, parameter
from pellucid.smooth_step import risen

FULLEST = 0.999
"""Reduced volume to which a film can be brought: at 1 only the sphere is left, volume and area leave it no motion, and the
equations for its velocity are singular. Curves and meridians of 8 nodes and surfaces of 42 reach this one."""


class VolumeCase(Model):
    """The volume inside a film, which it keeps, or brings to another."""

    reduced: float | None = parameter(
        "", "target reduced volume; 1 for a sphere of the same area; default: the volume is constant", None, gt=0
    )
    over: float | None = parameter(
        "s", "duration of the smooth change from the initial volume; required with `reduced`", None, gt=0
    )

    def problems(self, path: Path, plane: bool, keeps_area: bool) -> Iterator[Finding]:
        """Findings: a volume above that of a sphere or circle, a change without a time, or at an area that is free."""
        if self.reduced is None:
            if self.over is not None:
                yield Finding((*path, "over"), "applies to a changing volume", "add `reduced`, or remove this")
            return
        if self.reduced > FULLEST:
            curve, full, of = ("curve", "circle", "length") if plane else ("surface", "sphere", "area")
            if self.reduced > 1.0:
                text = f"{self.reduced:g} is impossible: no {curve} encloses more than a {full} of the same {of}, which has 1"
            else:
                text = f"{self.reduced:g} is above {FULLEST:g}: a {full}, which has 1, cannot move at constant volume and {of}"
            remedy = f"use at most {FULLEST:g}; for a {full}, start with one, without `volume` and `area`"
            yield Finding((*path, "reduced"), text, remedy)
        if self.over is None:
            text = "an instantaneous change of volume would need an infinite velocity"
            yield Finding(path, text, "add `over = ...`, the duration of the change, such as the relaxation time of the film")
        if not keeps_area:
            text = "refers to a fixed area, but the area of this film is free and would change"
            yield Finding((*path, "reduced"), text, 'add area = "kept"')


class Goals(NamedTuple):
    """The volume [m³] and area [m²] that are prescribed; None where they are free."""

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
