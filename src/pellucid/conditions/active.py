"""All conditions of a case, and its rigid bodies, as they act in a run."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from pellucid.conditions.constrained_nodes import constrain_nodes, nodal_support
from pellucid.conditions.rigid import RigidBody
from pellucid.conditions.support import Support
from pellucid.energy import Channel, StepWork
from pellucid.grid.momentum import ExternalAction, Supports, external_action
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.assembly import ActiveCondition, AssembledBody, Assembly, load_channels
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import Condition


class BodiesAndConditions(Protocol):
    """The bodies and conditions of a case."""

    @property
    def body(self) -> Sequence[BodyModel]: ...
    @property
    def support(self) -> Sequence[Support]: ...
    def conditions(self) -> Mapping[type[Condition], Sequence[Condition]]: ...


def channels_of_loads(case: BodiesAndConditions) -> tuple[Channel, ...]:
    """The channels of the external forces of a case."""
    names = (condition.load_channel() for several in case.conditions().values() for condition in several)
    return load_channels([name for name in names if name is not None])


class ActiveConditions:
    """The conditions of a case and its rigid bodies, for bodies that are built.

    bodies: by name, each with the velocity field that it is in; fields: all of these. external, supports: what acts on the
    nodes of each velocity field and what constrains them.
    """

    def __init__(
        self,
        case: BodiesAndConditions,
        bodies: Mapping[str, tuple[Body, VelocityField | None]],
        fields: Sequence[VelocityField],
    ) -> None:
        loads = channels_of_loads(case)
        members = {model.name: AssembledBody(bodies[model.name][0], model, bodies[model.name][1]) for model in case.body}
        self.supports: list[Supports] = [constrain_nodes(field.grid, case.support) for field in fields]
        for member in members.values():
            grid = member.velocity_field.grid if member.velocity_field else None
            member.body.add_supports([nodal_support(grid, support) for support in case.support])
        self.external = [self._external(field, case, members, len(loads)) for field in fields]
        assembly = Assembly(members, dict(zip(fields, self.external, strict=True)), loads, len(case.support))
        self._active: list[ActiveCondition] = [
            RigidBody(member, assembly) for member in members.values() if member.model.is_rigid
        ]
        for kind, conditions in case.conditions().items():
            self._active += kind.activate(conditions, assembly)
        for member in members.values():
            if member.body.constraint is not None:
                member.body.renew_totals()  # what bounds the step of a body may have changed
        self._fields = fields
        self.channels = tuple(dict.fromkeys([*loads, *(channel for part in self._active for channel in part.channels)]))

    @staticmethod
    def _external(
        field: VelocityField, case: BodiesAndConditions, members: Mapping[str, AssembledBody], n_loads: int
    ) -> ExternalAction:
        """External actions on the nodes of a velocity field, all zero, with rows for the conditions of its bodies."""
        every = [condition for several in case.conditions().values() for condition in several]
        named = ((condition.nodal, condition.acts_on()) for condition in every)
        here = {nodal for nodal, name in named if name is not None and members[name].velocity_field is field}
        loaded = field.moves_points and "loads" in here
        return external_action(field.grid.n_nodes, n_loads, loaded, "absorption" in here, "driven" in here)

    def begin(self, time: float, dt: float) -> None:
        """Set the actions of the step that begins at `time` [s]."""
        for field in self._fields:
            field.clear_external()
        for part in self._active:
            part.begin(time, dt)

    def works(self) -> list[StepWork]:
        """Work and impulses of the conditions over the step, but for those that nodes and bodies count."""
        works = (part.work() for part in self._active)
        return [work for work in works if work is not None]
