"""Data model of prescribed motions of bodies or parts of bodies."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import ClassVar

from pellucid.conditions.signals import AlongAxes, Signal, Turn
from pellucid.conditions.signals.turns import TurnModel, checked_displacement, displacement_fault
from pellucid.conditions.support import Axis
from pellucid.energy import IMPACT_HEAT, MOTION_WORK, Channel
from pellucid.findings import Finding, Path, Reason, listed
from pellucid.geometry.region import Where, faults
from pellucid.geometry.shapes.contract import AXES
from pellucid.model import Model, check, name_parameter, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.body_model import BodyModel, selectable_of
from pellucid.parts.condition import Condition, LoadKind
from pellucid.parts.part import Parts
from pellucid.step.part import StepPart


class Rotations(Model):
    """Prescribed rotations about axes with fixed directions through the centre of mass; rotations that are not given are
    free."""

    x: Turn | None = parameter("", "rotation about x as a function of time", None)
    y: Turn | None = parameter("", "rotation about y as a function of time", None)
    z: Turn | None = parameter("", "rotation about z as a function of time", None)

    def turns(self) -> dict[str, TurnModel]:
        """Return the prescribed rotations, by the name of their axis."""
        found = {axis: getattr(self, axis) for axis in AXES}
        return {axis: turn for axis, turn in found.items() if turn is not None}

    def axes(self) -> set[str]:
        """Return the names of the axes about which rotations are prescribed."""
        return set(self.turns())


def turn_problems(motion: "Motion", body: BodyModel, path: Path, parts: Parts, others: "Iterable[Motion]") -> Iterator[Finding]:
    """Yield findings if a body is not rigid but its motion prescribes or prevents a rotation, or if a motion of a rigid
    body has a `part`, a rotation that a thin grid does not allow, or a component that another motion already prescribes.
    body: model of the body of the motion; path: location of the motion in the case; parts: all parts of the case; others:
    the motions before this motion in the case."""
    about = "rotation" if motion.rotation.axes() else "hold_rotation"
    if not body.is_rigid:
        text = f"body {body.name} is not rigid: its points can only follow displacements"
        yield Finding((*path, about), text, "set `rigid = true` for the body, or give `hold` and `displacement` only")
        return
    if motion.part is not None:
        yield Finding(
            (*path, "part"),
            f"body {body.name} is rigid: a motion moves it as a whole, so `part` cannot be used",
            "remove `part`",
        )
    yield from plane_turn_problems(motion.rotation.axes(), (*path, "rotation"), parts)
    yield from plane_turn_problems(set(motion.held_turns), (*path, "hold_rotation"), parts)
    for other in others:
        yield from _shared_problems(motion, other, path)


def plane_turn_problems(axes: set[str], path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield a finding about rotations about `axes` (names of axes) that are impossible because the grid is one cell thick
    along another axis; path: key for the finding; parts: all parts of the case."""
    thin = {axis for axis, counts in zip(AXES, parts.active_axes, strict=True) if not counts}
    if strange := sorted(axis for axis in axes if thin - {axis}):
        along = listed(sorted(thin))
        turns = f"bodies rotate about {along} only, not about {strange[0]}" if len(thin) == 1 else "bodies cannot rotate"
        text = f"the grid is one cell thick along {along}: {turns}"
        yield Finding(path, text, f"remove {strange[0]}, or enlarge the grid along {listed(sorted(thin - {strange[0]}))}")


def plane_way_problems(motion: "Motion", path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings about prescribed displacements along axes along which the grid is one cell thick; path: location of
    the condition in the case; parts: all parts of the case."""
    for axis, counts in zip(AXES, parts.active_axes, strict=True):
        if not counts and getattr(motion.displacement, axis) is not None:
            text = f"the grid is one cell thick along {axis}: nothing moves along this axis"
            yield Finding((*path, "displacement", axis), text, f"remove {axis}, or enlarge the grid along it")


def _shared_problems(motion: "Motion", other: "Motion", path: Path) -> Iterator[Finding]:
    if other.body != motion.body:
        return
    along, about = motion.axes() & other.axes(), motion.turns_about() & other.turns_about()
    if along or about:
        what = f"along {AXES[min(along)]}" if along else f"about {AXES[min(about)]}"
        text = f"the motion {other.name} already prescribes body {motion.body} {what}"
        yield Finding((*path, "name"), text, "remove it from one of the two")


WAYS = ("x", "y", "z", "normal")


class Displacements(AlongAxes):
    """Prescribed displacements along the axes; axes without a displacement are free."""

    normal: Signal | None = parameter(
        "",
        "displacement of nodes of a fluid film along its present normal; tangentially they are free. Cannot "
        "be combined with x, y, z",
        None,
    )


class Motion(Condition):
    """Prescribed displacement of points of a body, independent of the forces on them.

    A body with `rigid = true` follows displacements of its centre of mass and rotations about it; components that are not
    given are free.
    """

    # work of the motion, and energy lost by points that take its velocity instantly
    losses: ClassVar[Sequence[Channel]] = (MOTION_WORK, IMPACT_HEAT)
    unique_name: ClassVar[bool] = True
    load_kind: ClassVar[LoadKind] = "dead"
    name: str = name_parameter("name of the motion, for probes of its reaction")
    body: str = parameter("", "name of the body")
    part: Where | None = parameter("", "region at the start whose points move; default: the whole body", None)
    hold: tuple[Axis, ...] = parameter("", "directions along which the points are fixed", ())
    displacement: Displacements = parameter("", "displacement as a function of time", Displacements())
    hold_rotation: tuple[Axis, ...] | None = parameter(
        "", "axes about which a rigid body cannot rotate; about all others it rotates freely", None
    )
    rotation: Rotations = parameter("", "rotation of a rigid body about its centre of mass", Rotations())

    @check
    def _prescribes_each_axis_once(self) -> None:
        moved = [axis for axis in WAYS if getattr(self.displacement, axis) is not None]
        if both := sorted(set(moved) & set(self.hold)):
            raise ValueError(f"{both[0]} is in both `hold` and `displacement`; remove it from one")
        if "normal" in moved and len(moved) + len(self.hold) > 1:
            other = sorted({*moved, *self.hold} - {"normal"})[0]
            raise ValueError(f"{other} cannot be combined with `normal`, which leaves the nodes free along the film; remove it")
        if both := sorted(self.rotation.axes() & set(self.held_turns)):
            raise ValueError(f"{both[0]} is in both `hold_rotation` and `rotation`; remove it from one")
        if not moved and not self.hold and not self.turns_about():
            raise ValueError(
                'this motion prescribes no direction: give `hold = ["x", ...]` or a `displacement`, for example '
                '{ y = { kind = "sine", amplitude = 1e-5, period = 1e-4 } }'
            )

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that does not exist or cannot follow a prescribed motion. path: location of the
        condition in the case; parts: all parts of the case."""
        yield from parts.unknown(BodyModel, (*path, "body"), self.body)
        yield from self._signal_problems((*path, "displacement"))
        yield from plane_way_problems(self, path, parts)
        body = parts.named(BodyModel, self.body)
        along = self.displacement.normal is not None
        if body is not None and (reason := _why_not(body, along, self.part is None)):
            yield Finding((*path, "displacement", "normal") if along else (*path, "body"), *reason)
        elif body is not None and (body.is_rigid or self.turns_about()):
            others = [other for place, other in parts.placed(Motion) if place < path]
            yield from turn_problems(self, body, path, parts, others)
        elif body is not None and self.part is not None and (nodes := selectable_of(body, parts)) is not None:
            yield from faults(self.part, nodes, (*path, "part"), self.body, parts.active_axes)

    def _signal_problems(self, path: Path) -> Iterator[Finding]:
        """Yield findings about displacements or rotations that are invalid functions of time at the start; path: path of the
        key `displacement` of the motion."""
        for axis in WAYS:
            signal = getattr(self.displacement, axis)
            if signal is not None and (why := displacement_fault(signal, f"motion {self.name} along {axis}")):
                yield Finding((*path, axis), why)
        for axis, turn in self.rotation.turns().items():
            if why := displacement_fault(turn, f"motion {self.name} about {axis}"):
                yield Finding((*path[:-1], "rotation", axis), why)

    @classmethod
    def activate(cls, conditions: Sequence["Motion"], assembly: Assembly) -> Sequence[StepPart]:
        """Build one active condition for all motions of a body; motions of a fluid film act along its normal. Motions of
        rigid bodies are left out, since the condition `Rigid` applies these motions."""
        from pellucid.conditions.prescribed_points import NormalMotions, PrescribedPoints

        result: list[StepPart] = []
        for name, member in assembly.bodies.items():
            if member.model.is_rigid:
                continue  # handled by the condition for rigid bodies
            motions = [motion for motion in conditions if motion.body == name]
            if any(motion.displacement.normal is not None for motion in motions):
                result.append(NormalMotions(member, motions))
            elif motions:
                result.append(PrescribedPoints(member, motions, assembly))
        return result

    def reaction(self) -> str | None:
        return self.name

    def prescribed_axes(self, body: str) -> set[int]:
        return self.axes() if body == self.body and self.part is None else set()

    def functions(self) -> dict[int, Callable[[float], float]]:
        """Return the displacement [m] as a function of time [s] for each prescribed axis, by the index of the axis."""
        result: dict[int, Callable[[float], float]] = {"xyz".index(axis): lambda t: 0.0 for axis in self.hold}
        for number, axis in enumerate("xyz"):
            signal = getattr(self.displacement, axis)
            if signal is not None:
                result[number] = checked_displacement(signal, f"motion {self.name} along {axis}")
        return result

    def turn_functions(self) -> dict[int, Callable[[float], float]]:
        """Return the angle [rad] as a function of time [s] for each axis with a prescribed rotation, by the index of the
        axis."""
        result: dict[int, Callable[[float], float]] = {"xyz".index(axis): lambda t: 0.0 for axis in self.held_turns}
        for axis, turn in self.rotation.turns().items():
            result["xyz".index(axis)] = checked_displacement(turn, f"motion {self.name} about {axis}")
        return result

    def along_normal(self) -> Callable[[float], float]:
        """Return the displacement along the normal [m] as a function of time [s]; zero if none is prescribed."""
        signal = self.displacement.normal
        return (lambda t: 0.0) if signal is None else checked_displacement(signal, f"motion {self.name} along the normal")

    def axes(self) -> set[int]:
        """Return the indices of the axes with prescribed displacements."""
        return {
            number for number, axis in enumerate("xyz") if axis in self.hold or getattr(self.displacement, axis) is not None
        }

    @property
    def held_turns(self) -> tuple[Axis, ...]:
        """Axes about which the motion prevents rotations of a rigid body."""
        return self.hold_rotation or ()

    def turns_about(self) -> set[int]:
        """Return the indices of the axes about which the motion prescribes the rotation."""
        return {"xyz".index(axis) for axis in {*self.held_turns, *self.rotation.axes()}}

    def turning_reaction(self, parts: Parts) -> str | None:
        body = parts.named(BodyModel, self.body)
        return self.name if body is not None and body.is_rigid else None

    def top_turn(self) -> float:
        """Return the largest prescribed angular velocity about an axis [rad/s]."""
        return max((turn.top_speed() for turn in self.rotation.turns().values()), default=0.0)

    def top_speed(self) -> float:
        """Return the largest prescribed velocity along an axis [m/s]."""
        signals = (getattr(self.displacement, axis) for axis in WAYS)
        return max((signal.top_speed() for signal in signals if signal is not None), default=0.0)


def _why_not(body: BodyModel, along_normal: bool, whole: bool) -> Reason | None:
    """Return the reason why nodes of the body (all of them if `whole`) cannot follow a prescribed motion along the axes, or
    `along_normal`; None if they can."""
    if along_normal:
        from pellucid.conditions.prescribed_points import why_no_normal_motion

        return why_no_normal_motion(body, whole)
    if not body.moves:
        return Reason(f"the nodes of body {body.name} are fixed and cannot follow a motion", "remove this motion")
    if body.takes_motions:
        return None
    text = f'the nodes of body {body.name}, of kind "{body.kind}", cannot follow a prescribed motion along the axes'
    return Reason(text, "use a support with a `velocity`, or for a fluid film a displacement along the `normal`")
