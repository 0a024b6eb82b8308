"""Load: a force and a torque on a rigid body."""

from collections.abc import Iterator
from typing import Literal

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.loads.rigid_load import NONE, Push, RigidLoad, rigid_of, thin_problems
from pellucid.energy import Channel
from pellucid.findings import Finding, Path, Refusal
from pellucid.model import Vector, check, parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.part import Parts
from pellucid.step.part import AtEachStep, StepPart


class RigidForce(ChangesInTime, RigidLoad):
    """A force at the centre of mass of a rigid body and a torque, both with fixed directions."""

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
