"""Data model of prescribed rotations of rigid bodies, and checks of motions of rigid bodies."""

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

from pellucid.conditions.signals import Turn
from pellucid.conditions.signals.turns import TurnModel
from pellucid.findings import Finding, Path, listed
from pellucid.geometry.shapes.contract import AXES
from pellucid.model import Model, parameter
from pellucid.parts.body_model import BodyModel
from pellucid.parts.part import Parts

if TYPE_CHECKING:
    from pellucid.conditions.prescribed_motion import Motion


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
