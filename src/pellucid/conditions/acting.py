"""Everything that acts on the bodies from outside, at work together."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from pellucid.bodies.contract import Body
from pellucid.conditions.at_work import ConditionAtWork, Home, World, load_channels
from pellucid.conditions.constrained_nodes import constrain_nodes, held_nodes
from pellucid.conditions.rigid import RigidBody
from pellucid.conditions.support import Support
from pellucid.energy import Channel, StepWork
from pellucid.grid.momentum import ExternalAction, Supports, external_action
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts import BodyModel, Condition


class Given(Protocol):
    """The bodies and conditions of a case."""

    @property
    def body(self) -> Sequence[BodyModel]: ...
    @property
    def support(self) -> Sequence[Support]: ...
    def conditions(self) -> Mapping[type[Condition], Sequence[Condition]]: ...


def channels_of_loads(case: Given) -> tuple[Channel, ...]:
    """The channels of the external forces of a case."""
    names = (condition.load_channel() for several in case.conditions().values() for condition in several)
    return load_channels([name for name in names if name is not None])


class ActingConditions:
    """The conditions of a case and its rigid bodies, for bodies that are built.

    bodies: by name, each with the velocity field that it is in; fields: all of these. external, supports: what acts on the
    nodes of each field and what constrains them.
    """

    def __init__(
        self, case: Given, bodies: Mapping[str, tuple[Body, VelocityField | None]], fields: Sequence[VelocityField]
    ) -> None:
        loads = channels_of_loads(case)
        homes = {model.name: Home(bodies[model.name][0], model, bodies[model.name][1]) for model in case.body}
        self.supports: list[Supports] = [constrain_nodes(field.grid, case.support) for field in fields]
        for home in homes.values():
            grid = home.field.grid if home.field else None
            home.body.hold([held_nodes(grid, support) for support in case.support])
        self.external = [self._external(field, case, homes, len(loads)) for field in fields]
        world = World(homes, dict(zip(fields, self.external, strict=True)), loads, len(case.support))
        self._at_work: list[ConditionAtWork] = [RigidBody(home, world) for home in homes.values() if home.model.is_rigid]
        for kind, conditions in case.conditions().items():
            self._at_work += kind.at_work(conditions, world)
        for home in homes.values():
            if home.body.constraint is not None:
                home.body.renew_totals()  # what bounds the step of a body may have changed
        self._fields = fields
        self.channels = tuple(dict.fromkeys([*loads, *(channel for part in self._at_work for channel in part.channels)]))

    @staticmethod
    def _external(field: VelocityField, case: Given, homes: Mapping[str, Home], n_loads: int) -> ExternalAction:
        """What acts on the nodes of a velocity field, all zero, with room for what the conditions of its bodies need."""
        every = [condition for several in case.conditions().values() for condition in several]
        named = ((condition.nodal, condition.acts_on()) for condition in every)
        here = {nodal for nodal, name in named if name is not None and homes[name].field is field}
        loaded = field.moves_points and "loads" in here
        return external_action(field.grid.n_nodes, n_loads, loaded, "absorption" in here, "driven" in here)

    def begin(self, time: float, dt: float) -> None:
        """What acts over the step that begins at `time` [s]."""
        for field in self._fields:
            field.clear_external()
        for part in self._at_work:
            part.begin(time, dt)

    def works(self) -> list[StepWork]:
        """What the conditions did over the step, but for what nodes and bodies count themselves."""
        works = (part.work() for part in self._at_work)
        return [work for work in works if work is not None]
