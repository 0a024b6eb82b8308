"""Load: a force per unit area on faces."""

from collections.abc import Iterator
from functools import cache
from typing import Literal

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.loaded_faces import LoadedFaces, face_problems
from pellucid.conditions.loads.contract import LoadModel
from pellucid.findings import Finding, Path
from pellucid.geometry.region import Where
from pellucid.model import Vector, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.part import Parts
from pellucid.step.part import AtEachStep, StepPart


class Traction(ChangesInTime, LoadModel):
    """A dead load on faces of a body with its own nodes: a force with fixed direction per unit initial area."""

    kind: Literal["traction"] = "traction"
    where: Where = parameter("", "faces of the body")
    traction: Vector = parameter("Pa", "force per unit initial area of the faces")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that does not exist or has no faces in the region of the load. path: location of the
        condition in the case; parts: all parts of the case."""
        yield from super().problems(path, parts)
        yield from face_problems(self.where, (*path, "where"), self.body, parts)

    def active(self, assembly: Assembly, path: Path) -> StepPart:
        faces = LoadedFaces(assembly.bodies[self.body], self.where, (*path, "where"))
        add, forces = assembly.forces_on(self.body, self.channel), cache(lambda: faces.traction(np.array(self.traction)))
        return AtEachStep(lambda time: add(self.share(time) * forces()))
