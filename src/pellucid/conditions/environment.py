"""Everything that acts on the bodies from outside, at work together."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from pellucid.conditions.absorbing import Absorbing, absorption_rates
from pellucid.conditions.motion import Motion
from pellucid.conditions.prescribed import ConstraintWork, Drive, Rigid
from pellucid.conditions.pressure import Pressure
from pellucid.grid.grid import Grid
from pellucid.grid.motion import Outside
from pellucid.grid.pressing import press


class Environment:
    """Pressures, absorbing faces, prescribed motions and rigid bodies of a case, for bodies that are built."""

    def __init__(
        self,
        grid: Grid,
        bodies: Sequence[Any],
        motions: Sequence[Motion],
        rigid: Sequence[str],
        absorbing: Sequence[Absorbing],
        pressures: Sequence[Pressure],
    ) -> None:
        named = {body.name: body for body in bodies}
        rows = {"load": bool(pressures), "absorption": bool(absorbing)}
        self.outside = Outside(*(np.zeros((grid.n_nodes if rows.get(f, bool(motions)) else 0, 3)) for f in Outside._fields))
        for condition in absorbing:
            body = named[condition.body]
            speeds = body.material.wave_speeds()
            self.outside.absorption[:] += absorption_rates(grid, body.functions, [(face, *speeds) for face in condition.where])
        self._pressures = [(named[condition.body], condition) for condition in pressures]
        self._constraints: list[Drive | Rigid] = [Rigid(named[name]) for name in rigid]
        for body in bodies:
            own = [motion for motion in motions if motion.body == body.name]
            if own:
                self._constraints.append(Drive(body, own, self.outside))
        for constraint in self._constraints:
            constraint.body.constraint = constraint
            constraint.body.measure()  # what bounds the step of a body may change
        # the entries of the energy ledger that such conditions need
        present = {"load": pressures, "absorbed": absorbing, "motion": motions, "impact_heat": self._constraints}
        self.works = tuple(name for name, conditions in present.items() if conditions)

    def begin(self, time: float, dt: float) -> None:
        """What acts over the step that begins at `time` [s]."""
        for array in (self.outside.load, self.outside.driven_mass, self.outside.driven_momentum):
            array.fill(0.0)
        for constraint in self._constraints:
            constraint.begin(time, dt)
        for body, condition in self._pressures:
            press(body.n_slabs, body.mapped, body.fans, self.outside.load, condition.at(time))

    def collect(self) -> ConstraintWork:
        """What the constraints did over the step."""
        parts = [constraint.collect() for constraint in self._constraints]
        impulses: Mapping[str, np.ndarray] = {name: impulse for part in parts for name, impulse in part.impulses.items()}
        return ConstraintWork(sum(part.work for part in parts), sum(part.loss for part in parts), dict(impulses))
