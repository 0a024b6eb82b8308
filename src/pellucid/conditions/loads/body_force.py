"""Load: an acceleration of one body."""

from typing import Literal

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.loads.contract import LoadModel
from pellucid.findings import Path
from pellucid.model import Vector, parameter
from pellucid.parts.annotations import Assembly
from pellucid.step.part import AtEachStep, StepPart


class BodyForce(ChangesInTime, LoadModel):
    """A force proportional to mass: an acceleration of one body, such as in an accelerated frame."""

    kind: Literal["body-force"] = "body-force"
    acceleration: Vector = parameter("m/s^2", "force per unit mass")

    def active(self, assembly: Assembly, path: Path) -> StepPart:
        body, add = assembly.bodies[self.body].body, assembly.forces_on(self.body, self.channel)
        acceleration = np.array(self.acceleration)
        return AtEachStep(lambda time: add(body.arrays["mass"][:, None] * (self.share(time) * acceleration)))
