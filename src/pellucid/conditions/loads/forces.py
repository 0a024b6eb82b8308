"""Loads that are given forces: per unit mass, distributed over points, or per unit area of faces."""

from collections.abc import Iterator
from functools import cache
from typing import ClassVar, Literal

import numpy as np

from pellucid.conditions.loaded_faces import LoadedFaces, face_problems
from pellucid.conditions.loads.contract import LoadModel, chosen_points, chosen_problems
from pellucid.conditions.signals.time_table import ChangesInTime
from pellucid.findings import Finding, Path
from pellucid.geometry.region import Where
from pellucid.model import Vector, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.condition import LoadKind
from pellucid.parts.part import Parts
from pellucid.step.part import AtEachStep, StepPart


class BodyForce(ChangesInTime, LoadModel):
    """A force proportional to mass: an acceleration of one body, such as in an accelerated frame."""

    load_kind: ClassVar[LoadKind] = "dead"
    kind: Literal["body-force"] = "body-force"
    acceleration: Vector = parameter("m/s^2", "force per unit mass")

    def accelerates(self, axis: int) -> bool:
        return self.acceleration[axis] != 0.0

    def active(self, assembly: Assembly, path: Path) -> StepPart:
        body, add = assembly.bodies[self.body].body, assembly.forces_on(self.body, self.channel)
        acceleration = np.array(self.acceleration)
        return AtEachStep(lambda time: add(body.arrays["mass"][:, None] * (self.share(time) * acceleration)))


class PointLoad(ChangesInTime, LoadModel):
    """A force with fixed direction, distributed equally over the nodes or points of a body in a region."""

    load_kind: ClassVar[LoadKind] = "dead"
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


class Traction(ChangesInTime, LoadModel):
    """A dead load on faces of a body with its own nodes: a force with fixed direction per unit initial area."""

    load_kind: ClassVar[LoadKind] = "dead"
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
