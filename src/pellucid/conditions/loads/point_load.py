"""Load: a force distributed over points."""

from collections.abc import Iterator
from typing import Literal

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.loads.chosen_points import chosen_points, chosen_problems
from pellucid.conditions.loads.contract import LoadModel
from pellucid.findings import Finding, Path
from pellucid.geometry.region import Where
from pellucid.model import Vector, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.part import Parts
from pellucid.step.part import AtEachStep, StepPart


class PointLoad(ChangesInTime, LoadModel):
    """A force with fixed direction, distributed equally over the nodes or points of a body in a region."""

    kind: Literal["point-load"] = "point-load"
    where: Where = parameter("", "nodes or points of the body")
    force: Vector = parameter("N", "total force on these nodes or points")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that does not exist or has no nodes in the region of the load. path: location of the
        condition in the case; parts: all parts of the case."""
        yield from super().problems(path, parts)
        yield from chosen_problems(self.where, self.body, path, parts)

    def active(self, assembly: Assembly, path: Path) -> StepPart:
        member, force = assembly.bodies[self.body], np.array(self.force)
        chosen, add = chosen_points(self.where, member, path), assembly.forces_on(self.body, self.channel)
        share = np.where(chosen, 1.0 / chosen.sum(), 0.0)[:, None]  # in the order of `id`, which sorting keeps
        return AtEachStep(lambda time: add(share[member.body.arrays["id"]] * (self.share(time) * force)))
