"""Pressure that follows a membrane or the faces of a solid."""

from collections.abc import Iterator, Sequence
from typing import Literal

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.film_tractions import surface_load
from pellucid.conditions.loaded_faces import LoadedFaces, face_problems, in_plane_problem
from pellucid.findings import Finding, Path
from pellucid.geometry.region import Where, faults
from pellucid.model import check, parameter
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
    where: Where | None = parameter("", "which faces; without it all of a membrane, all outer ones of a solid", None)
    choose: Literal["start", "each-step"] = parameter(
        "",
        "when the faces of `where` are chosen: once, so that they stay pressed wherever they go, or anew in each step, by their "
        "centres, so that the region stays where it is",
        "start",
    )

    @check
    def _chooses_something(self) -> None:
        if self.choose == "each-step" and self.where is None:
            raise ValueError("`choose` belongs to `where`: give a region, or leave it out")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A body that is not there or has no normal, faces that are not there."""
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        body = parts.named(BodyModel, self.body)
        if body is None:
            return
        place, each_step = (*path, "body" if self.where is None else "where"), self.choose == "each-step"
        if body.is_surface and self.where is not None:
            yield from self._region_problems(self.where, place, body, parts)
        elif not body.is_surface and body.selectable() is None:
            text = f"body {self.body} is no membrane and has no mesh: it has no normal to push along"
            yield Finding((*path, "body"), text, "name a membrane or a meshless-solid")
        elif not body.is_surface:
            yield from face_problems(self.where or "boundary", place, self.body, parts, each_step)

    def _region_problems(self, where: Where, path: Path, body: BodyModel, parts: Parts) -> Iterator[Finding]:
        """Of a region of a membrane."""
        start = body.selectable()
        if body.evaluates_loads or start is None:
            text = f'body {self.body} is of kind "{body.kind}", on all of which a pressure acts'
            yield Finding(path, text, "leave `where` out; a [[load]] of kind film-pressure may have a `band`")
        elif not all(parts.active_axes):
            yield in_plane_problem(path, self.body)
        else:
            yield from faults(where, start, path, self.body, faces=True, by_centre=True)

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
        is_surface = member.body.is_surface
        if not is_surface or self.where is not None:
            each_step, outward = self.choose == "each-step", -1.0 if is_surface else 1.0
            path = ("pressure", number, "where")
            faces = LoadedFaces(member, self.where or "boundary", path, is_surface or each_step, each_step)
            add = assembly.forces_on(self.body, channel)
            return AtEachStep(lambda time: add(faces.pressure(outward * self.at(time))))
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
