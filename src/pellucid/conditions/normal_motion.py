"""Prescribed motions of nodes of a fluid film along its normal."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.conditions.prescribed_points import marked
from pellucid.findings import Finding, refuse
from pellucid.parts.assembly import AssembledBody
from pellucid.parts.capabilities import TakesNormalMotions
from pellucid.step.part import StepPart

if TYPE_CHECKING:
    from pellucid.conditions.prescribed_motion import Motion


class NormalMotions(StepPart):
    """Prescribed displacements of nodes of one fluid film along the normal of the film. The film itself records the work
    and the impulses of these displacements."""

    def __init__(self, member: AssembledBody, motions: "Sequence[Motion]") -> None:
        self._functions = [motion.along_normal() for motion in motions]
        numbers = marked(member, motions)
        if reason := member.model.why_no_normal_motion(whole=bool((numbers > 0).all())):
            refuse([Finding(("motion", motions[0].name, "displacement"), *reason)])
        self._body = member.offers(TakesNormalMotions)
        self._body.add_normal_motions([motion.name for motion in motions], numbers)

    def begin(self, time: float, dt: float) -> None:
        """Set the mean normal velocities over a step dt [s] from `time` [s], so that the nodes end exactly at the prescribed
        displacements."""
        self._body.set_normal_velocities(np.array([(of(time + dt) - of(time)) / dt for of in self._functions]))
