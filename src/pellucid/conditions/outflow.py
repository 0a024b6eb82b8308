"""Data model of an outflow: faces of the grid through which material points leave the simulation."""

from collections.abc import Iterator, Sequence

from pydantic import field_validator

from pellucid.conditions.open_faces.given_flow import GivenFlow
from pellucid.conditions.open_faces.inflow import Inflow, face_problems, why_no_outflow
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.support import Face
from pellucid.energy import IMPACT_HEAT, INFLOW_ENERGY, OUTFLOW_ENERGY, OUTFLOW_WORK, Channel
from pellucid.findings import Finding, Path, Reason
from pellucid.model import check, name_parameter, one_or_several, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import LosesPoints
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart


class Outflow(GivenFlow, Condition):
    """Faces of the grid through which material points leave: a point that crosses such a face is removed, and the run
    continues.

    At a `pressure` a fluid flows out or in, as the flow requires; with `velocity` or `flow_rate`, points leave with this
    prescribed flow.
    """

    name: str | None = name_parameter("name of the outflow, for probes of its force (quantity `reaction`)", None)
    where: tuple[Face, ...] = parameter("", "faces of the grid", min_length=1)
    body: tuple[str, ...] = parameter(
        "", "bodies whose points can leave; default: all bodies of material points without prescribed motion", ()
    )
    pressure: float | None = parameter(
        "Pa", "pressure outside, changed in time by `rise` and `amplitude`; negative values are suction", None
    )

    _one_or_several = field_validator("where", "body", mode="before")(one_or_several)

    @check
    def _is_one_kind(self) -> None:
        given = [*(["pressure"] if self.pressure is not None else []), *self.sizes()]
        if len(given) > 1:
            raise ValueError(f"`{given[0]}` and `{given[1]}` cannot be combined at a face; remove one of the two")
        if self.is_led and len(self.where) > 1:
            raise ValueError(f"`{given[0]}` applies to one face; use one [[outflow]] per face")
        own = {"profile": self.profile != "uniform", "through": self.through is not None, "name": self.name is not None}
        if not self.is_led and (extra := [key for key, written in own.items() if written]):
            raise ValueError(f"`{extra[0]}` belongs to a prescribed flow: add `velocity` or `flow_rate`, or remove it")
        if not given and (self.rise > 0.0 or self.amplitude is not None):
            raise ValueError(
                "there is nothing to change in time: add `pressure`, `velocity` or `flow_rate`, or remove `rise` and "
                "`amplitude`"
            )

    def opens_face(self, face: str) -> bool:
        return face in self.where

    def load_channel(self) -> str | None:
        return None if self.pressure is None else OUTFLOW_WORK.name

    def channels(self) -> Sequence[Channel]:
        led, pressed = self.is_led, self.pressure is not None
        return (OUTFLOW_ENERGY, *([OUTFLOW_WORK, IMPACT_HEAT] if led else []), *([INFLOW_ENERGY] if pressed else []))

    def why_not_steady(self) -> Reason | None:
        """Return the reason why no steady state can be computed with a prescribed flow: there is no equilibrium."""
        if not self.is_led:
            return None
        return Reason(
            "an [[outflow]] with a prescribed flow removes points, so there is no equilibrium", "remove [steady] or the flow"
        )

    def reaction(self) -> str | None:
        return self.name

    @classmethod
    def activate(cls, conditions: Sequence["Outflow"], assembly: Assembly) -> Sequence[StepPart]:
        """Open the faces for the points of the bodies; return the parts that remove points which crossed them, and those of
        pressures and prescribed flows."""
        led = {name for name, member in assembly.bodies.items() if member.body.constraint is not None}
        active, losing = list[StepPart](), dict[str, LosesPoints]()
        for number, outflow in enumerate(conditions):
            bodies = []
            for name, member in assembly.bodies.items():
                allowed = name in outflow.body if outflow.body else name not in led and not why_no_outflow(member.model)
                if allowed:
                    ends = [("xyz".index(face[0]), int(face.endswith("upper"))) for face in outflow.where]
                    losing[name] = member.offers(LosesPoints)
                    losing[name].open_faces(ends)
                    bodies.append(name)
            active += outflow._acting(bodies, assembly, f"outflow.{outflow.name or number}")
        if not losing:
            return active
        from pellucid.conditions.open_faces.entering import LeavingPoints

        return [LeavingPoints([losing[name] for name in assembly.bodies if name in losing]), *active]

    def _acting(self, bodies: Sequence[str], assembly: Assembly, path: str) -> list[StepPart]:
        """Return the active conditions that apply the pressure or the prescribed flow at the faces to bodies (names); path:
        path of the outflow in the case, for messages."""
        if self.pressure is not None and bodies:
            from pellucid.conditions.open_faces.pressure_face import PressureFace

            return [PressureFace(self, face, bodies, OUTFLOW_WORK, assembly, path) for face in self.where]
        if self.is_led:
            from pellucid.conditions.open_faces.strip import LeadingOut

            return [LeadingOut(self, bodies, assembly, path)]
        return []

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about faces that cannot be open, and bodies that cannot lose points. path: location of the
        condition in the case; parts: all parts of the case."""
        yield from parts.no_grid((*path, "where"), "faces belong to a grid")
        for number, face in enumerate(self.where):
            here = (*path, "where", number)
            if face in self.where[:number]:
                yield from parts.seam(here, face)
                yield Finding(here, f"the face {face} is listed twice", "remove one of the two names")
                continue
            yield from face_problems(face, here, parts)
            if inflows := [place for place, inflow in parts.placed(Inflow) if inflow.where == face]:
                text = f"inflow number {int(inflows[0][1]) + 1} enters through the face {face}: nothing can leave through it"
                yield Finding(here, text, "remove the face from one of the two")
            yield from self._repeated(face, here, parts)
            if self.is_led:
                yield from self.opening_problems(face, path, parts)
        yield from self._body_problems((*path, "body"), parts)

    def _repeated(self, face: str, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding if another outflow with a pressure or a flow has the same face (its name); path: location in the
        case for the finding; parts: all parts of the case."""
        for place, other in parts.placed(Outflow):
            acts = [one.is_led or one.pressure is not None for one in (self, other)]
            if place < path[:2] and face in other.where and all(acts):
                text = f"outflow number {int(place[1]) + 1} already has a pressure or a flow at the face {face}"
                yield Finding(path, text, "remove the face from one of the two")

    def _body_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        for number, name in enumerate(self.body):
            yield from parts.unknown(BodyModel, (*path, number), name)
            body = parts.named(BodyModel, name)
            if body is not None and (reason := _why_not(body, parts)):
                yield Finding((*path, number), *reason)
        bodies = parts.of(BodyModel)
        if not self.body and bodies and parts.are_sound(BodyModel) and all(_why_not(body, parts) for body in bodies):
            text = (
                "no body can lose points: only bodies of material points can that are not rigid, follow no motion "
                "and have no cell_pressure"
            )
            yield Finding(path[:-1], text, "remove this outflow")


def _why_not(body: BodyModel, parts: Parts) -> Reason | None:
    """Return the reason why the points of a body cannot leave through faces of the grid; None if they can."""
    if reason := why_no_outflow(body):
        return reason
    led = next((motion.name for motion in parts.of(Motion) if motion.body == body.name), None)
    if led is None:
        return None
    return Reason(f"body {body.name} follows the motion `{led}`, so it cannot lose points", "remove this body from `bodies`")
