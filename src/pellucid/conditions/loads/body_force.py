"""An acceleration of one body."""

from typing import Literal

import numpy as np

from pellucid.conditions.amplitude import ChangesInTime
from pellucid.conditions.loads.contract import LoadModel
from pellucid.findings import Path
from pellucid.model import Vector, parameter
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.annotations import Assembly


class BodyForce(ChangesInTime, LoadModel):
    """A force on every mass: an acceleration of one body, as of a frame that speeds up the other way."""

    kind: Literal["body-force"] = "body-force"
    acceleration: Vector = parameter("m/s^2", "force on unit mass")

    def active(self, assembly: Assembly, path: Path) -> ActiveCondition:
        """Its forces."""
        return ActiveBodyForce(self, assembly)


class ActiveBodyForce(ActiveCondition):
    """An acceleration of a body that is built, on its points as they are stored."""

    def __init__(self, load: BodyForce, assembly: Assembly) -> None:
        self._body, self._load = assembly.bodies[load.body].body, load
        self._add = assembly.forces_on(load.body, load.channel)

    def begin(self, time: float, dt: float) -> None:
        """Its forces over the step."""
        acceleration = self._load.share(time) * np.array(self._load.acceleration)
        self._add(self._body.arrays["mass"][:, None] * acceleration)
