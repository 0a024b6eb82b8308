"""Data model of an inflow: a face of the grid through which points enter a fluid."""

from collections.abc import Iterator, Sequence

from pellucid.conditions.open_faces.given_flow import GivenFlow
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.support import Face
from pellucid.energy import IMPACT_HEAT, INFLOW_ENERGY, INFLOW_WORK, OUTFLOW_ENERGY, Channel
from pellucid.findings import Finding, Path, Reason, Refusal
from pellucid.model import check, name_parameter, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel
from pellucid.parts.capabilities import LosesPoints
from pellucid.parts.condition import Condition
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart


class Inflow(GivenFlow, Condition):
    """A face of the grid through which points enter a fluid, with a prescribed velocity in the layer of cells there; under a
    pressure, points enter or leave as the flow requires."""

    name: str | None = name_parameter("name of the inflow, for probes of its force (quantity `reaction`)", None)
    where: Face = parameter("", "face of the grid")
    body: str = parameter("", "name of the entering fluid of material points; it enters in its initial state")

    pressure: float | None = parameter(
        "Pa", "alternative: pressure at the face, changed in time by `rise` and `amplitude`; the fluid may flow back", None
    )

    @check
    def _has_one_size(self) -> None:
        given = [*self.sizes(), *(["pressure"] if self.pressure is not None else [])]
        if len(given) > 1:
            raise Refusal(f"both `{given[0]}` and `{given[1]}`", "give one of them")
        if not given:
            raise Refusal("neither `velocity` nor `flow_rate` nor `pressure`", "give one of them")

    def opens_face(self, face: str) -> bool:
        return face == self.where

    def load_channel(self) -> str | None:
        return None if self.pressure is None else INFLOW_WORK.name

    def channels(self) -> Sequence[Channel]:
        return (INFLOW_ENERGY, *([INFLOW_WORK, IMPACT_HEAT] if self.pressure is None else [OUTFLOW_ENERGY]))

    @classmethod
    def activate(cls, conditions: Sequence["Inflow"], assembly: Assembly) -> Sequence[StepPart]:
        """Return the parts through which points enter, and those that remove points which leave again through a face under a
        pressure."""
        from pellucid.conditions.open_faces.entering import LeavingPoints, PrescribedInflow, inflow_opening
        from pellucid.conditions.open_faces.pressure_face import PressureFace

        active, losing = list[StepPart](), list[LosesPoints]()
        for number, inflow in enumerate(conditions):
            path = f"inflow.{inflow.name or number}"
            if inflow.pressure is None:
                active.append(PrescribedInflow(inflow, assembly, path))
                continue
            inflow_opening(inflow, assembly.bodies[inflow.body], path)  # an opening that is filled is an error of the case
            losing.append(assembly.bodies[inflow.body].offers(LosesPoints))
            losing[-1].open_faces([("xyz".index(inflow.where[0]), int(inflow.where.endswith("upper")))])
            active.append(PressureFace(inflow, inflow.where, [inflow.body], INFLOW_WORK, assembly, path))
        return [LeavingPoints(losing), *active] if losing else active

    def reaction(self) -> str | None:
        return self.name if self.pressure is None else None

    def why_not_steady(self) -> Reason | None:
        """Return the reason why no steady state can be computed: with an inflow there is no equilibrium."""
        return Reason("an [[inflow]] adds points, so there is no equilibrium", "remove [steady] or the inflow")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about faces that cannot be open, bodies that points cannot enter, and flows that are too fast.
        path: location of the condition in the case; parts: all parts of the case."""
        yield from parts.no_grid((*path, "where"), "faces belong to a grid")
        yield from face_problems(self.where, (*path, "where"), parts)
        seeded = parts.named(BodyModel, self.body)
        comes_in = seeded if seeded is not None and not _why_no_inflow(seeded) else None
        yield from self.opening_problems(self.where, path, parts, comes_in)
        for place, other in parts.placed(Inflow):
            if place < path and other.where == self.where and (self.through is None or other.through is None):
                text = f"inflow number {int(place[1]) + 1} also uses the face {self.where}"
                yield Finding(
                    (*path, "where"), text, "divide the face: give each inflow or outflow its own part of it with `through`"
                )
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        body = parts.named(BodyModel, self.body)
        if body is not None:
            yield from self._body_problems(body, path, parts)
        yield from self._speed_problems(path, parts)

    def _body_problems(self, body: BodyModel, path: Path, parts: Parts) -> Iterator[Finding]:
        if reason := _why_no_inflow(body):
            yield Finding((*path, "body"), *reason)
            return
        if led := next((motion.name for motion in parts.of(Motion) if motion.body == body.name), None):
            text = f"body {body.name} follows the motion `{led}`, so no point can enter it"
            yield Finding((*path, "body"), text, "remove the motion, or the inflow")
        for place, load in parts.placed(Condition):
            chooses = getattr(load, "body", None) == body.name and getattr(load, "where", None) is not None
            if place[0] == "load" and chooses:
                text = f"`where` selects points at the start only, but points enter body {body.name} later"
                yield Finding((*place, "where"), text, "remove `where`: the load then acts on all points")
        if "start" in parts.sections and parts.sections["start"].is_written:
            text = f"body {body.name} cannot continue from an earlier run, because points enter it"
            yield Finding((*path, "body"), text, "use `pellucid resume` to continue a run, or remove [start]")

    def _speed_problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield a finding about a fixed time step in which the inflow crosses more than one cell. path: location of the
        condition in the case; parts: all parts of the case."""
        step = getattr(parts.sections["time"].items[0], "step", None)
        if parts.grid is None or step is None or self.velocity is None:
            return
        fastest = self.largest_share() * self.velocity
        if fastest * step > parts.grid.cell:
            text = f"at {fastest:g} m/s points cross {fastest * step / parts.grid.cell:.3g} cells in a step of {step:g} s"
            remedy = f"use time.step = {0.8 * parts.grid.cell / fastest:.2g} or less, or remove time.step"
            yield Finding((*path, "velocity"), text, remedy)


def face_problems(face: str, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings about a face of the grid (its name) that cannot have inflow or outflow: a face on a periodic axis, a
    face on an axis along which the grid is one cell thick, or a face whose nodes are all constrained along its normal.
    path: key that names the face."""
    yield from parts.seam(path, face)
    if parts.grid is not None and not parts.active_axes["xyz".index(face[0])]:
        text = f"the grid is one cell thick along {face[0]}: nothing can move through the face {face}"
        yield Finding(path, text, "remove this flow")
        return
    closed = next((place for place, each in parts.placed(Condition) if each.face_velocity(face) is not None), None)
    if closed is not None:
        where = f"{'.'.join(map(str, closed))}.where"
        text = f"`{where}` constrains the whole face {face} along its normal: nothing can flow through it"
        remedy = (
            f'remove "{face}" from `{where}`; for a wall next to an opening, use a [[support]] with a region, '
            "`where = { box = ... }` or `{ pipe = ... }`, one cell deep. Or remove this flow"
        )
        yield Finding(path, text, remedy)


def why_no_outflow(body: BodyModel) -> Reason | None:
    """Return the reason why points of the body cannot leave through faces of the grid, or None."""
    if not body.separate_points:
        text = f"the points of body {body.name} are connected, so they cannot leave one by one"
        return Reason(text, "use only bodies of kind material-points")
    return _why_not_through_faces(body)


def _why_no_inflow(body: BodyModel) -> Reason | None:
    if not body.separate_points:
        text = f"the points of body {body.name} are connected, so no points can be added"
        return Reason(text, "use a body of kind material-points")
    if not body.is_fluid:
        return Reason(f"body {body.name} is a solid: entering points would not be connected to it", "name a fluid")
    return _why_not_through_faces(body)


def _why_not_through_faces(body: BodyModel) -> Reason | None:
    """Return the reason why separate points cannot pass faces of the grid: the body is rigid, or its mean pressures of full
    cells treat faces as walls."""
    if body.is_rigid:
        return Reason(f"body {body.name} is rigid: it cannot lose points", "remove `rigid = true`, or this body")
    if getattr(body, "cell_pressure", False):
        text = f"the `cell_pressure` of body {body.name} treats faces of the grid as walls, so points cannot pass through them"
        return Reason(text, "remove `cell_pressure`, or this body")
    return None
