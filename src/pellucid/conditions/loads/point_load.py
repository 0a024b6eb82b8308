"""A force shared by points."""

from collections.abc import Iterator
from typing import Literal

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.loads.chosen_points import chosen_points, chosen_problems
from pellucid.conditions.loads.contract import LoadModel
from pellucid.findings import Finding, Path
from pellucid.geometry.region import Where
from pellucid.model import Vector, parameter
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.annotations import Assembly
from pellucid.parts.part import Parts


class PointLoad(ChangesInTime, LoadModel):
    """A force that the nodes or points of a region share equally; its direction is fixed."""

    kind: Literal["point-load"] = "point-load"
    where: Where = parameter("", "which nodes or points of the body")
    force: Vector = parameter("N", "force on all of them together")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A body that is not there or has no such nodes."""
        yield from super().problems(path, parts)
        yield from chosen_problems(self.where, self.body, path, parts)

    def active(self, assembly: Assembly, path: Path) -> ActiveCondition:
        """Its forces."""
        return ActivePointLoad(self, assembly, path)


class ActivePointLoad(ActiveCondition):
    """A force on points of a body that is built."""

    def __init__(self, load: PointLoad, assembly: Assembly, path: Path) -> None:
        member = assembly.bodies[load.body]
        self._body, self._load = member.body, load
        chosen = chosen_points(load.where, member, path)
        self._share = np.where(chosen, 1.0 / chosen.sum(), 0.0)[:, None]  # of the points by their `id`: sorting moves them
        self._add = assembly.forces_on(load.body, load.channel)

    def begin(self, time: float, dt: float) -> None:
        """Its forces over the step."""
        force = self._load.share(time) * np.array(self._load.force)
        self._add(self._share[self._body.arrays["id"]] * force)
