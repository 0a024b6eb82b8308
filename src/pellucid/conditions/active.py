"""All conditions of a case during a run: forces on nodes, step limits, points that enter the grid, work of the conditions,
and their states for checkpoints."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from pellucid.conditions.support import Support, on_each_face
from pellucid.energy import Channel, Passed, StepWork, WorkLayout, channel_of_load
from pellucid.grid.actions import NodalActions
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.assembly import AssembledBody, Assembly
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition
from pellucid.parts.step_limit import StepLimit, tightest


class BodiesAndConditions(Protocol):
    """Interface of the model of a case from which the conditions of a run are built: `body` and `support` are the lists of
    these tables; `conditions()` returns all other conditions too, by their class."""

    @property
    def body(self) -> Sequence[BodyModel]: ...
    @property
    def support(self) -> Sequence[Support]: ...
    def conditions(self) -> Mapping[type[Condition], Sequence[Condition]]: ...


def layout_of(case: BodiesAndConditions, others: Iterable[Channel] = (), touching: bool = False) -> WorkLayout:
    """Return the layout of the array that collects the work of each step [J]: one column for each channel (entry of the
    energy balance) of the conditions of the case, and for each channel in `others`. touching: True if surfaces are in
    contact, whose forces then have a column for their work."""
    every = [condition for several in case.conditions().values() for condition in several]
    loads = [channel_of_load(name) for condition in every if (name := condition.load_channel()) is not None]
    stated = [channel for condition in every for channel in condition.channels()]
    return WorkLayout(loads, [*stated, *others], len(on_each_face(case.support)), touching)


class ActiveConditions:
    """All conditions of a case during a run, built for its bodies.

    bodies: each body by name, with its velocity field (None without a grid); fields: all velocity fields; layout: columns
    of the array that collects the work of a step. Attribute `actions`: for each velocity field the object through which
    conditions act on its nodes.
    """

    def __init__(
        self,
        case: BodiesAndConditions,
        bodies: Mapping[str, tuple[Body, VelocityField | None]],
        fields: Sequence[VelocityField],
        layout: WorkLayout,
    ) -> None:
        self.actions = [NodalActions(field, layout.n_loads) for field in fields]
        of = dict(zip(fields, self.actions, strict=True))
        members: dict[str, AssembledBody] = {}
        for model in case.body:
            body, field = bodies[model.name]
            members[model.name] = AssembledBody(body, model.with_others(case.body), None if field is None else of[field])
        assembly = Assembly(members, self.actions, layout)
        self._active: list[ActiveCondition] = []
        for kind, conditions in case.conditions().items():
            self._active += kind.activate(conditions, assembly)
        for member in members.values():
            member.body.complete()
        for condition in self._active:
            condition.try_out()
        acting = [one for one in self._active if type(one).act_on_nodes is not ActiveCondition.act_on_nodes]
        pushed = [fields if one.pushed_fields is None else one.pushed_fields for one in acting]
        self.pushed_fields = {field for several in pushed for field in several}
        """Velocity fields to whose nodes conditions may apply impulses."""

    def begin(self, time: float, dt: float) -> None:
        """Clear the external forces on the nodes, and let each condition set its forces or prescribed velocities for the
        step that begins at `time` [s]. dt: increment of the time of the loads in this step [s], 0 while bodies settle or
        are relaxed."""
        for actions in self.actions:
            actions.field.clear_external()
        for condition in self._active:
            condition.begin(time, dt)

    def act_on_nodes(self, dt: float) -> None:
        """Apply impulses to the nodes for the step dt [s], after the momentum update and before contact."""
        for condition in self._active:
            condition.act_on_nodes(dt)

    def end(self, dt: float) -> None:
        """Update the conditions after the bodies have completed the step dt [s]."""
        for condition in self._active:
            condition.end(dt)

    def enter(self, n_steps: int, time: float) -> Iterator[Passed]:
        """Let each condition insert points into bodies (inflow) after step number `n_steps`, which ended at `time` [s];
        yield a record for each insertion: number, mass, momentum and energy of the new points."""
        for condition in self._active:
            yield from condition.enter(n_steps, time)

    def impulses(self) -> dict[str, np.ndarray]:
        """Return the impulses over the step that only the conditions record [N s], shape (3,), by the name under which
        probes (requested histories of a quantity) read them; impulses of other conditions are part of the sums of nodes
        and bodies."""
        return {name: impulse for condition in self._active for name, impulse in condition.impulses().items()}

    def step_limit(self) -> StepLimit:
        """Return the smallest limit of the time step that a condition sets, with its reason; `NO_LIMIT` if there is none."""
        return tightest(condition.step_limit() for condition in self._active)

    def warnings(self) -> list[str | None]:
        """Return for each condition its warning about the last step, or None."""
        return [condition.warning() for condition in self._active]

    def at_stake(self) -> float:
        """Return the energy that the conditions store at the start and could release [J]. It is part of the reference
        energy that divides the error of the energy balance."""
        return sum(condition.at_stake() for condition in self._active)

    def columns(self) -> dict[str, float]:
        """Return the values that conditions write to the history (a table with one row per output time) in SI units, by the
        name of the column."""
        return {name: value for condition in self._active for name, value in condition.columns().items()}

    def state_numbers(self) -> list[dict[str, Any]]:
        """Return the state of each condition for a checkpoint, as values by name."""
        return [dict(condition.state_numbers()) for condition in self._active]

    def restore(self, numbers: Sequence[Mapping[str, Any]]) -> None:
        """Restore the states of the conditions from a checkpoint; numbers: state of each condition as values by name, in
        the order in which `state_numbers` returned them."""
        for condition, own in zip(self._active, numbers, strict=True):
            condition.restore(own)

    def works(self) -> list[StepWork]:
        """Return the work and the impulses of each condition over the step; conditions whose work the nodes or bodies
        record themselves are left out."""
        works = (condition.work() for condition in self._active)
        return [work for work in works if work is not None]
