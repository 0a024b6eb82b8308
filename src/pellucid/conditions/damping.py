"""Damping of a body: the condition for the keys `damping` and `damping_until` of a body."""

from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from pellucid.energy import DAMPING, DAMPING_HEAT, Channel, StepWork
from pellucid.model import parameter
from pellucid.parts.annotations import Assembly
from pellucid.parts.capabilities import TakesDrag
from pellucid.parts.condition import Condition
from pellucid.step.part import StepPart


class Damping(Condition):
    """Drag on a body, proportional to mass and velocity."""

    losses: ClassVar[Sequence[Channel]] = (DAMPING_HEAT,)  # energy removed by the drag

    body: str = parameter("", "name of the body on whose points the drag acts")
    rate: float = parameter("1/s", "decay rate of the velocity of a free body", gt=0)
    until: float | None = parameter("s", "time at which the drag ends; default: never", None)

    @classmethod
    def activate(cls, conditions: Sequence["Damping"], assembly: Assembly) -> Sequence[StepPart]:
        return [ActiveDamping(damping, assembly) for damping in conditions]

    def mean_rate(self, time: float, dt: float) -> float:
        """Return the damping rate [1/s], averaged over a step dt [s] that begins at `time` [s]; 0 if dt is 0, as while bodies
        settle."""
        if dt == 0.0:
            return 0.0
        return self.rate if self.until is None else self.rate * min(max((self.until - time) / dt, 0.0), 1.0)


class ActiveDamping(StepPart):
    """Applies the drag force of a `Damping` condition, proportional to mass and velocity, to the body of this condition in
    each step."""

    def __init__(self, damping: Damping, assembly: Assembly) -> None:
        self._damping, self._layout = damping, assembly.layout
        self._body = assembly.bodies[damping.body].offers(TakesDrag)
        self._lost, self._impulse = 0.0, np.zeros(3)

    def begin(self, time: float, dt: float) -> None:
        self._lost, self._impulse = self._body.damp(self._damping.mean_rate(time, dt), dt)

    def work(self) -> StepWork:
        done = self._layout.no_work()
        done.works[DAMPING] = self._lost
        done.impulse[:] = self._impulse
        return done
