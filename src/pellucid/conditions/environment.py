"""Everything that acts on the bodies from outside, at work together."""

from collections.abc import Mapping, Sequence

import numpy as np

from pellucid.conditions.absorbing import Absorbing, absorption_rates
from pellucid.conditions.own_nodes import OwnDrive
from pellucid.conditions.prescribed import ConstraintWork, Drive, Rigid
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.pressure import Pressure
from pellucid.conditions.support import Support
from pellucid.grid.momentum import ExternalAction, external_action_with
from pellucid.grid.velocity_field import VelocityField

GRIPPING = ("driven_mass", "driven_momentum", "impulse")


class Environment:
    """Pressures, absorbing faces, prescribed motions and rigid bodies of a case, for bodies that are built."""

    def __init__(
        self,
        velocity_fields: Sequence[VelocityField],
        supports: Sequence[Support],
        motions: Sequence[Motion],
        rigid: Sequence[str],
        absorbing: Sequence[Absorbing],
        pressures: Sequence[Pressure],
    ) -> None:
        named = {
            body.name: (body, number) for number, velocity_field in enumerate(velocity_fields) for body in velocity_field.bodies
        }
        self.outsides = [self._outside(velocity_field, motions, absorbing, pressures) for velocity_field in velocity_fields]
        for condition in absorbing:
            body, number = named[condition.body]
            speeds = body.material.wave_speeds()
            faces = [(face, *speeds) for face in condition.where]
            self.outsides[number].absorption[:] += absorption_rates(body.grid, body.functions, faces)
        self._pressures = [(*named[condition.body], condition) for condition in pressures]
        self._constraints: list[Drive | Rigid] = [Rigid(named[name][0]) for name in rigid]
        for body, number in named.values():
            own = [motion for motion in motions if motion.body == body.name]
            if body.own_nodes:
                self._constraints.append(OwnDrive(body, own, self.outsides[number], supports))
            elif own:
                self._constraints.append(Drive(body, own, self.outsides[number]))
        for constraint in self._constraints:
            constraint.body.constraint = constraint
            constraint.body.measure()  # what bounds the step of a body may change
        # the entries of the energy ledger that such conditions need
        present = {"load": pressures, "absorbed": absorbing, "motion": motions, "impact_heat": self._constraints}
        self.works = tuple(name for name, conditions in present.items() if conditions)

    @staticmethod
    def _outside(
        velocity_field: VelocityField, motions: Sequence[Motion], absorbing: Sequence[Absorbing], pressures: Sequence[Pressure]
    ) -> ExternalAction:
        names = {body.name for body in velocity_field.bodies}
        parts = GRIPPING if any(motion.body in names for motion in motions) else ()
        if any(condition.body in names for condition in absorbing):
            parts = (*parts, "absorption")
        if any(condition.body in names for condition in pressures):
            parts = (*parts, "load")
        return external_action_with(parts, velocity_field.grid.n_nodes)

    def begin(self, time: float, dt: float) -> None:
        """What acts over the step that begins at `time` [s]."""
        for outside in self.outsides:
            for array in (outside.load, outside.driven_mass, outside.driven_momentum):
                array.fill(0.0)
        for constraint in self._constraints:
            constraint.begin(time, dt)
        for body, number, condition in self._pressures:
            body.press(self.outsides[number].load, condition.at(time))

    def collect(self) -> ConstraintWork:
        """What the constraints did over the step."""
        parts = [constraint.collect() for constraint in self._constraints]
        impulses: Mapping[str, np.ndarray] = {name: impulse for part in parts for name, impulse in part.impulses.items()}
        return ConstraintWork(sum(part.work for part in parts), sum(part.loss for part in parts), dict(impulses))
