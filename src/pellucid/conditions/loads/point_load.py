"""A force shared by points."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, Literal

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.loads.contract import LoadModel
from pellucid.findings import Finding, Path, refuse
from pellucid.geometry.region import Where, chosen_nodes, faults
from pellucid.model import Vector, parameter
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts

if TYPE_CHECKING:
    from pellucid.parts.assembly import Assembly


class PointLoad(ChangesInTime, LoadModel):
    """A force that the nodes or points of a region share equally; its direction is fixed."""

    kind: Literal["point-load"] = "point-load"
    where: Where = parameter("", "which nodes or points of the body")
    force: Vector = parameter("N", "force on all of them together")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A body that is not there or has no such nodes."""
        yield from super().problems(path, parts)
        body = parts.named(BodyModel, self.body)
        if body is not None and (start := body.selectable()) is not None:
            yield from faults(self.where, start, (*path, "where"), self.body, parts.active_axes)

    def active(self, assembly: "Assembly", path: Path) -> ActiveCondition:
        """Its forces."""
        return ActivePointLoad(self, assembly, path)


class ActivePointLoad(ActiveCondition):
    """A force on points of a body that is built."""

    def __init__(self, load: PointLoad, assembly: "Assembly", path: Path) -> None:
        member = assembly.bodies[load.body]
        self._body, self._load, start = member.body, load, member.body.selectable()
        refuse(faults(load.where, start, (*path, "where"), load.body, member.active_axes))
        self._share = np.zeros((self._body.n_points, 1))  # of the points by their `id`: sorting moves them
        chosen = chosen_nodes(load.where, start, member.active_axes)
        self._share[self._body.arrays["id"][chosen]] = 1.0 / chosen.sum()
        self._column = assembly.load_column(load.body, load.channel)

    def begin(self, time: float, dt: float) -> None:
        """Its forces over the step."""
        force = self._load.share(time) * np.array(self._load.force)
        self._body.add_external_force(self._share[self._body.arrays["id"]] * force, self._column)
