"""Pressure that follows a membrane or the faces of a solid."""

from collections.abc import Iterator, Sequence

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.film_tractions import surface_load
from pellucid.conditions.loaded_faces import LoadedFaces, face_problems
from pellucid.findings import Finding, Path
from pellucid.geometry.region import Where
from pellucid.model import parameter
from pellucid.parts.active_condition import ActiveCondition, AtEachStep
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import TakesPressure, TakesTractions
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts
from pellucid.parts.surface_load import SurfacePoints


class Pressure(ChangesInTime, Condition):
    """A pressure difference on a membrane or a pressure on the faces of a solid, along the normal wherever that points."""

    body: str = parameter("", "name of a membrane, or of a solid with nodes of its own")
    value: float = parameter(
        "Pa", "pressure behind a membrane minus that before it: it pushes along the normal; on a solid, against the outward one"
    )
    where: Where | None = parameter("", "which faces of a solid; without it all of its outer ones", None)

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A body that is not there or has no normal, faces that are not there."""
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        body = parts.named(BodyModel, self.body)
        if body is None:
            return
        if body.is_surface and self.where is not None:
            text = f"body {self.body} is a membrane, on all of which a pressure acts"
            yield Finding((*path, "where"), text, "leave `where` out; it is for faces of a solid")
        elif not body.is_surface and body.selectable() is None:
            text = f"body {self.body} is no membrane and has no mesh: it has no normal to push along"
            yield Finding((*path, "body"), text, "name a membrane or a meshless-solid")
        elif not body.is_surface:
            place = (*path, "body" if self.where is None else "where")
            yield from face_problems(self.where or "boundary", place, self.body, parts)

    def load_channel(self) -> str:
        """Shared with other loads."""
        return "load_work"

    @classmethod
    def activate(cls, conditions: Sequence["Pressure"], assembly: Assembly) -> Sequence[ActiveCondition]:
        """One for each."""
        return [pressure.active(assembly, number) for number, pressure in enumerate(conditions)]

    def active(self, assembly: Assembly, number: int) -> ActiveCondition:
        """What acts in a run; number: its place among the pressures of the case."""
        member, channel = assembly.bodies[self.body], self.load_channel()
        if not member.body.is_surface:
            faces = LoadedFaces(member, self.where or "boundary", ("pressure", number, "where"))
            add = assembly.forces_on(self.body, channel)
            return AtEachStep(lambda time: add(faces.pressure(self.at(time))))
        if isinstance(member.body, TakesTractions):
            return surface_load(self.traction, self.body, channel, assembly, f"pressure.{number}")
        membrane, column = member.offers(TakesPressure), assembly.load_column(self.body, channel)
        return AtEachStep(lambda time: membrane.add_pressure(self.at(time), column))

    def at(self, time: float) -> float:
        """Pressure [Pa] at a time [s]."""
        return self.value * self.share(time)

    def traction(self, points: SurfacePoints, time: float) -> np.ndarray:
        """Force on unit of present area [Pa], shape (..., 3), at a time [s]."""
        return self.at(time) * points.normal
