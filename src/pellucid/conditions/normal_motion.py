"""Prescribed motions of nodes of a fluid film along its normal."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.bodies.fluid_film.model import FluidFilmCase
from pellucid.conditions.prescribed_points import marked
from pellucid.findings import Finding, Reason, refuse
from pellucid.parts.assembly import AssembledBody
from pellucid.parts.body_model import BodyModel
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
        if reason := why_no_normal_motion(member.model, whole=bool((numbers > 0).all())):
            refuse([Finding(("motion", motions[0].name, "displacement"), *reason)])
        self._body = member.offers(TakesNormalMotions)
        self._body.add_normal_motions([motion.name for motion in motions], numbers)

    def begin(self, time: float, dt: float) -> None:
        """Set the mean normal velocities over a step dt [s] from `time` [s], so that the nodes end exactly at the prescribed
        displacements."""
        self._body.set_normal_velocities(np.array([(of(time + dt) - of(time)) / dt for of in self._functions]))


def why_no_normal_motion(body: BodyModel, whole: bool) -> Reason | None:
    """Return the reason why nodes of the body (all of them if `whole`) cannot follow a prescribed motion along their normal,
    or None."""
    if not isinstance(body, FluidFilmCase):
        return Reason(f"body {body.name} is not a fluid film", "prescribe the displacement along x, y or z")
    if body.is_shared:
        text = f"the fluid around film {body.name} moves its nodes, so their motion cannot be prescribed"
        return Reason(text, "remove this motion")
    if not whole or (body.volume is None and body.area == "free"):
        return None
    held = "area" if body.volume is None else "volume"
    text = f"the motion prescribes all nodes of film {body.name}, whose {held} is already prescribed"
    return Reason(text, f"remove `{held}` of the film, or prescribe only a `part` of it")
