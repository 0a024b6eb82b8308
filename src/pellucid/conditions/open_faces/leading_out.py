"""Prescribed outflow in a run: the nodes in the strip of cells at the face have the velocity of the flow."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.conditions.open_faces.columns import OpenFace, opening_of
from pellucid.conditions.open_faces.strip import LedStrip, Passage, work_of_strip
from pellucid.energy import OUTFLOW_WORK, StepWork
from pellucid.errors import CaseError, Problem
from pellucid.parts.assembly import Assembly
from pellucid.step.limit import StepLimit
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.outflow import Outflow


class LeadingOut(StepPart):
    """Active outflow with a prescribed flow. Only one body flows out: the first in the list of bodies that has points at
    the face, through the opening of the outflow in the face."""

    def __init__(self, outflow: "Outflow", bodies: Sequence[str], assembly: Assembly, path: str) -> None:
        self._layout, self._name = assembly.layout, outflow.name
        for name in bodies:
            member = assembly.bodies[name]
            if member.velocity_field is None:
                continue
            case = member.velocity_field.grid.case
            face = OpenFace.of(outflow.where[0], case)
            columns, shape = opening_of(outflow.through, face, member.model, case)
            if columns.n:
                self._strip = LedStrip(outflow, Passage(face, columns, shape, case, member, -face.inward, path))
                break
        else:
            text = f"no body that can leave reaches the face {outflow.where[0]}, and no opening is defined"
            remedy = "extend a body to the face, or define an opening with `through`, one cell deep into the grid"
            raise CaseError(Problem(text, f"{path}.where", remedy=remedy))
        self._work, self._impulse = 0.0, np.zeros(3)

    def try_out(self) -> None:
        self._strip.find_profile()
        self._strip.speed = self._strip.mean_at(0.0)

    def begin(self, time: float, dt: float) -> None:
        self._strip.begin(time, dt)

    def act_on_nodes(self, dt: float) -> None:
        """Compute the work of the prescribed flow on the nodes over the step dt [s], and its impulse."""
        self._work, self._impulse = self._strip.act(dt)

    def step_limit(self) -> StepLimit:
        return self._strip.step_limit()

    def work(self) -> StepWork:
        return work_of_strip(self._layout, OUTFLOW_WORK, self._work, self._impulse, self._name)

    def state_numbers(self) -> dict[str, Any]:
        return {"speed": self._strip.speed}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        self._strip.speed = float(numbers["speed"])
