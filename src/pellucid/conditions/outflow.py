"""Outflow: faces of the grid through which material points leave the computation."""

from collections.abc import Iterator, Sequence
from typing import ClassVar

from pydantic import field_validator

from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.support import Face
from pellucid.energy import OUTFLOW_ENERGY, Channel
from pellucid.findings import Finding, Path, Reason
from pellucid.model import one_or_several, parameter
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import LosesPoints
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts


class Outflow(Condition):
    """Faces of the grid through which material points leave: a point that crosses one ends, and the run goes on."""

    losses: ClassVar[Sequence[Channel]] = (OUTFLOW_ENERGY,)  # what the points take along

    where: tuple[Face, ...] = parameter("", "faces of the grid", min_length=1)
    body: tuple[str, ...] = parameter(
        "", "bodies whose points may leave; without it all bodies of material points that nothing leads", ()
    )

    _one_or_several = field_validator("where", "body", mode="before")(one_or_several)

    @classmethod
    def activate(cls, conditions: Sequence["Outflow"], assembly: Assembly) -> Sequence[ActiveCondition]:
        """Bodies let their points go by themselves: nothing else acts in a step."""
        led = {name for name, member in assembly.bodies.items() if member.body.constraint is not None}
        for outflow in conditions:
            for name, member in assembly.bodies.items():
                allowed = name in outflow.body if outflow.body else name not in led and not member.model.why_no_outflow()
                if allowed:
                    ends = [("xyz".index(face[0]), int(face.endswith("upper"))) for face in outflow.where]
                    member.offers(LosesPoints).open_faces(ends)
        return ()

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Faces through which nothing can pass, and bodies that cannot lose points."""
        yield from parts.no_grid((*path, "where"), "faces are those of a grid")
        for number, face in enumerate(self.where):
            here = (*path, "where", number)
            yield from parts.seam(here, face)
            if face in self.where[:number]:
                yield Finding(here, f"the face {face} is named twice", "leave it out once")
            elif not parts.active_axes["xyz".index(face[0])]:
                text = f"the grid is one cell thick along {face[0]}: nothing moves through the face {face}"
                yield Finding(here, text, "leave it out")
            elif any(condition.face_velocity(face) is not None for condition in parts.of(Condition)):
                text = f"a support constrains the face {face} along its normal: nothing passes it"
                yield Finding(here, text, "take the face out of one of the two")
        yield from self._body_problems((*path, "body"), parts)

    def _body_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        for number, name in enumerate(self.body):
            yield from parts.unknown(BodyModel, (*path, number), name)
            body = parts.named(BodyModel, name)
            if body is not None and (reason := _why_not(body, parts)):
                yield Finding((*path, number), *reason)
        bodies = parts.of(BodyModel)
        if not self.body and bodies and parts.are_sound(BodyModel) and all(_why_not(body, parts) for body in bodies):
            text = (
                "no body can lose points: only material points can that follow no motion, are not rigid, have no cell_pressure"
            )
            yield Finding(path[:-1], text, "leave this outflow out")


def _why_not(body: BodyModel, parts: Parts) -> Reason | None:
    """Why the points of a body cannot leave."""
    if reason := body.why_no_outflow():
        return reason
    led = next((motion.name for motion in parts.of(Motion) if motion.body == body.name), None)
    if led is None:
        return None
    return Reason(f"body {body.name} follows the motion `{led}`, and cannot lose points", "leave this body out")
