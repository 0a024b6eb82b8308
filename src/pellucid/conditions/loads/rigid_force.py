"""A force and a torque on a rigid body."""

from collections.abc import Iterator
from typing import Literal

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.loads.rigid_load import OnRigidBody, RigidLoad, thin_problems
from pellucid.conditions.rigid.kinematics import Push
from pellucid.energy import Channel
from pellucid.findings import Finding, Path, Refusal
from pellucid.model import Vector, check, parameter
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.annotations import Assembly
from pellucid.parts.part import Parts

NONE = (0.0, 0.0, 0.0)


class RigidForce(ChangesInTime, RigidLoad):
    """A force at the centre of mass of a rigid body and a torque, both of fixed directions."""

    kind: Literal["rigid-force"] = "rigid-force"
    force: Vector = parameter("N", "force at the centre of mass", NONE)
    torque: Vector = parameter("N*m", "torque", NONE)

    @check
    def _is_something(self) -> None:
        if not any((*self.force, *self.torque)):
            raise Refusal("this load is nothing", "give a `force`, a `torque`, or both")

    def problems(self, path: Path, parts: Parts) -> Iterator[Finding]:
        """A body that is not rigid, directions in which nothing moves."""
        yield from super().problems(path, parts)
        yield from thin_problems(self.force, self.torque, ("force", "torque"), path, parts)

    def active(self, assembly: Assembly, path: Path) -> ActiveCondition:
        """Its force and torque."""
        return ActiveRigidForce(self, assembly)


class ActiveRigidForce(ActiveCondition):
    """A force and a torque on a rigid body that is built."""

    def __init__(self, load: RigidForce, assembly: Assembly) -> None:
        self._on, self._load = OnRigidBody(load, assembly), load
        self._column = assembly.layout.column(Channel(load.channel))

    def begin(self, time: float, dt: float) -> None:
        """Its share over the step."""
        share = self._load.share(time)
        self._on.rigid.add_load(Push(share * np.array([*self._load.force, *self._load.torque]), self._column))
