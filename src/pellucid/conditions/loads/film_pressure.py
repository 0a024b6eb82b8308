"""Pressure on a fluid film."""

from collections.abc import Iterator
from typing import Literal

import numpy as np

from pellucid.conditions.loads.contract import LoadModel
from pellucid.conditions.pressure import surface_load
from pellucid.conditions.signals.time_table import ChangesInTime
from pellucid.conditions.support import Axis
from pellucid.findings import Finding, Path
from pellucid.model import Model, Vector, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import SurfacePoints
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart


class Band(Model):
    """A band around the film, normal to an axis: the pressure decreases as exp(-(x - centre)²/(2 width²))."""

    axis: Axis = parameter("", "axis normal to the band", "z")
    centre: float = parameter("m", "position of the largest pressure along the axis", 0.0)
    width: float = parameter("m", "standard deviation of the pressure profile", gt=0)

    def share(self, position: np.ndarray) -> np.ndarray:
        """Return the fraction exp(-(x - centre)²/(2 width²)) of the largest pressure, with the coordinate x along the axis
        of the band, at positions [m], shape (..., 3)."""
        offset = (position[..., "xyz".index(self.axis)] - self.centre) / self.width
        return np.asarray(np.exp(-0.5 * offset * offset))


class FilmPressure(ChangesInTime, LoadModel):
    """A pressure along the current normal of a fluid film (Benet 2015, §§6.6 and 7.1.1)."""

    kind: Literal["film-pressure"] = "film-pressure"
    value: float = parameter("Pa", "pressure inside minus outside; with `along` or `band`, its largest value")
    on: Literal["present-area", "initial-area"] = parameter(
        "",
        "area for the force: present-area (follower load), or initial-area (the total force does not grow with the film)",
        "present-area",
    )
    along: Vector | None = parameter(
        "", "direction e: the pressure is `value` n·e with the normal n, like the pressure of a stream along e", None
    )
    band: Band | None = parameter("", "band across an axis to which the pressure is restricted", None)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that is not a fluid film, and a direction that is a zero vector. path: location of
        the condition in the case; parts: all parts of the case."""
        yield from super().problems(path, parts)
        body = parts.named(BodyModel, self.body)
        if body is not None and not body.evaluates_loads:
            text = f'body {self.body} is of kind "{body.kind}", but this load acts on fluid films only'
            yield Finding((*path, "body"), text, "name a body of kind fluid-film; for other bodies use a [[pressure]]")
        if self.along is not None and not any(self.along):
            yield Finding((*path, "along"), "the direction has zero length", "give a direction such as [0, 1, 0], or remove it")

    def active(self, assembly: Assembly, path: Path) -> StepPart:
        label = f"{'.'.join(map(str, path))} of kind {self.kind}"
        return surface_load(self.traction, self.body, self.channel, assembly, label)

    def traction(self, points: SurfacePoints, time: float) -> np.ndarray:
        """Return the force per unit current area [Pa], shape (..., 3), at points of the film surface and a time [s]."""
        pressure = np.full(points.density_ratio.shape, self.share(time) * self.value)
        if self.on == "initial-area":
            pressure = pressure * points.density_ratio
        if self.along is not None:
            pressure = pressure * (points.normal @ (np.array(self.along) / np.linalg.norm(self.along)))
        if self.band is not None:
            pressure = pressure * self.band.share(points.position)
        return np.asarray(pressure[..., None] * points.normal)
