"""Base of loads on rigid bodies as a whole, and the load that is given as a force and a torque."""

from collections.abc import Iterator
from typing import TYPE_CHECKING, ClassVar, Literal, NamedTuple

import numpy as np

from pellucid.conditions.loads.contract import LoadModel
from pellucid.conditions.prescribed_motion import plane_turn_problems
from pellucid.conditions.signals.time_table import ChangesInTime
from pellucid.energy import Channel
from pellucid.findings import Finding, Path, Refusal
from pellucid.geometry.shapes.contract import AXES
from pellucid.model import Vector, check, parameter
from pellucid.parts.annotations import Assembly, Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import LoadKind
from pellucid.parts.part import Parts
from pellucid.step.part import AtEachStep, StepPart

if TYPE_CHECKING:
    from pellucid.conditions.rigid.body import RigidBody


NONE = (0.0, 0.0, 0.0)


class Push(NamedTuple):
    """Force and torque of one load on a rigid body during a step, and the columns of the array of works that record their
    work."""

    strength: np.ndarray  # (6,) force at the centre of mass [N], then torque about it [N m]
    column: int  # column for the work in the array of works
    carried: np.ndarray | None = None  # (6,) velocity [m/s] and angular velocity [rad/s] of the anchor
    heat: int = 0  # column for the heat of a damper in the array of works

    def book(self, works: np.ndarray, dt: float, rates: np.ndarray) -> float:
        """Add the work of force and torque on the body over a step dt [s] to the array `works` [J]; for a damper, add the
        work of its moving anchor and the heat of the damper instead. Return the work on the body [J]. rates: velocity [m/s]
        and angular velocity [rad/s] of the body, shape (6,)."""
        work = dt * float(self.strength @ rates)
        if self.carried is None:
            works[self.column] += work
        else:
            given = dt * float(self.strength @ self.carried)
            works[self.column] += given
            works[self.heat] += given - work
        return work


class RigidLoad(LoadModel):
    """Base of loads (forces, torques, springs) that act on a rigid body as a whole."""

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that does not exist or is not rigid. path: location of the condition in the case;
        parts: all parts of the case."""
        yield from super().problems(path, parts)
        body = parts.named(BodyModel, self.body)
        if body is not None and not body.is_rigid:
            text = f"body {self.body} is not rigid: a {self.kind} acts on rigid bodies only"
            yield Finding((*path, "body"), text, 'set `rigid = true` for the body, or use kind = "body-force" or "point-load"')


def thin_problems(along: Vector, about: Vector, keys: tuple[str, str], path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings about nonzero force or torque components for which bodies cannot move in plane or one-dimensional
    problems. along: components of the force along x, y and z; about: components of the torque about x, y and z; keys: keys
    of `along` and `about` in the case; path: location of the condition in the case; parts: all parts of the case."""
    for axis, component, counts in zip(AXES, along, parts.active_axes, strict=True):
        if component and not counts:
            text = f"the grid is one cell thick along {axis}: nothing moves along this axis"
            yield Finding((*path, keys[0]), text, f"set its {axis} component to 0, or enlarge the grid along it")
    axes = {axis for axis, component in zip(AXES, about, strict=True) if component}
    yield from plane_turn_problems(axes, (*path, keys[1]), parts)


def rigid_of(body: Body) -> "RigidBody":
    """Return the object that moves a body as a rigid body; it is available when loads begin to act, i.e. in the first step.
    Raises ValueError for a body that is not rigid."""
    from pellucid.conditions.rigid.body import RigidBody

    if not isinstance(body.constraint, RigidBody):
        raise ValueError(f"body {body.name} is not rigid")
    return body.constraint


class RigidForce(ChangesInTime, RigidLoad):
    """A force at the centre of mass of a rigid body and a torque, both with fixed directions."""

    load_kind: ClassVar[LoadKind] = "dead"
    kind: Literal["rigid-force"] = "rigid-force"
    force: Vector = parameter("N", "force at the centre of mass", NONE)
    torque: Vector = parameter("N*m", "torque", NONE)

    @check
    def _is_something(self) -> None:
        if not any((*self.force, *self.torque)):
            raise Refusal("this load has no effect", "give a `force`, a `torque`, or both")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """Yield findings about a body that is not rigid, and components along axes without motion. path: location of the
        condition in the case; parts: all parts of the case."""
        yield from super().problems(path, parts)
        yield from thin_problems(self.force, self.torque, ("force", "torque"), path, parts)

    def active(self, assembly: Assembly, path: Path) -> StepPart:
        body, column = assembly.bodies[self.body].body, assembly.layout.column(Channel(self.channel))
        push = np.array([*self.force, *self.torque])
        return AtEachStep(lambda time: rigid_of(body).add_load(Push(self.share(time) * push, column)))
