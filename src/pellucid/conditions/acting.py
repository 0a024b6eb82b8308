"""Everything that acts on the bodies from outside, at work together."""

from collections.abc import Mapping, Sequence
from typing import Protocol

from pellucid.bodies.contract import Body
from pellucid.conditions.absorbing import Absorbing, absorption_rates
from pellucid.conditions.constrained_nodes import NO_AXES, constrain_nodes, held_nodes
from pellucid.conditions.load import Load, LoadsAtWork
from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.prescribed_points import PrescribedPoints
from pellucid.conditions.pressure import Pressure
from pellucid.conditions.rigid import RigidBody
from pellucid.conditions.support import Support
from pellucid.energy import ABSORBED_ENERGY, FIRST_LOAD, IMPACT_HEAT, MOTION_WORK, Channel, StepWork
from pellucid.grid.momentum import ExternalAction, Supports, external_action
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts import BodyModel


class Given(Protocol):
    """The bodies and conditions of a case."""

    @property
    def body(self) -> Sequence[BodyModel]: ...
    @property
    def support(self) -> Sequence[Support]: ...
    @property
    def motion(self) -> Sequence[Motion]: ...
    @property
    def absorbing(self) -> Sequence[Absorbing]: ...
    @property
    def pressure(self) -> Sequence[Pressure]: ...
    @property
    def load(self) -> Sequence[Load]: ...


def load_channels(case: Given) -> tuple[Channel, ...]:
    """The channels of the external forces of a case, each with a column of its own in the rows of works."""
    names = dict.fromkeys([*(["load_work"] if case.pressure else []), *(load.channel for load in case.load)])
    return tuple(Channel(name, 1.0, FIRST_LOAD + number) for number, name in enumerate(names))


class ActingConditions:
    """Supports, pressures, loads, absorbing faces, prescribed motions and rigid bodies of a case, for bodies that are built.

    bodies: by name, each with the velocity field that it is in.
    """

    def __init__(self, case: Given, bodies: Mapping[str, tuple[Body, VelocityField | None]]) -> None:
        self._loads = load_channels(case)
        self._columns, self._n_supports = FIRST_LOAD + len(self._loads), len(case.support)
        self._bodies = bodies
        self._fields = list(dict.fromkeys(field for _, field in bodies.values() if field is not None))
        self.external = [self._external(field, case) for field in self._fields]
        self.supports: list[Supports] = [constrain_nodes(field.grid, case.support) for field in self._fields]
        for body, field in bodies.values():
            body.hold([held_nodes(field.grid if field else None, support) for support in case.support])
        self._absorb(case)
        columns = {channel.name: channel.column for channel in self._loads}
        self._pressures = [(bodies[condition.body][0], condition, columns["load_work"]) for condition in case.pressure]
        self._forces = LoadsAtWork([body for body, _ in bodies.values()], case.load, columns)
        self._constraints: list[PrescribedPoints | RigidBody] = []
        for model in case.body:
            if not model.is_rigid:
                continue
            body, field = bodies[model.name]
            self._constraints.append(RigidBody(body, field.grid.thin if field else NO_AXES))
        for name, (body, field) in bodies.items():
            own = [motion for motion in case.motion if motion.body == name]
            if own:
                external = self.external[self._fields.index(field)] if field else None
                self._constraints.append(PrescribedPoints(body, own, external, field.grid.thin if field else NO_AXES))
        for constraint in self._constraints:
            constraint.body.constraint = constraint
        for constraint in self._constraints:
            constraint.body.renew_totals()  # what bounds the step of a body may change
        present = {MOTION_WORK: case.motion, ABSORBED_ENERGY: case.absorbing, IMPACT_HEAT: self._constraints}
        self.channels = (*self._loads, *(channel for channel, conditions in present.items() if conditions))

    def _external(self, field: VelocityField, case: Given) -> ExternalAction:
        names = {name for name, (_, home) in self._bodies.items() if home is field}
        pushed = {*(pressure.body for pressure in case.pressure), *(load.body for load in case.load)}
        loaded = field.moves_points and not names.isdisjoint(pushed)
        absorbs = any(condition.body in names for condition in case.absorbing)
        driven = any(condition.body in names for condition in case.motion)
        return external_action(field.grid.n_nodes, len(self._loads), loaded, absorbs, driven)

    def _absorb(self, case: Given) -> None:
        speeds = {model.name: model.wave_speeds for model in case.body}
        for condition in case.absorbing:
            body, field = self._bodies[condition.body]
            if field is None or body.on_grid is None:
                raise ValueError(f"body {condition.body} has no points on the grid whose waves a face could absorb")
            faces = [(face, *speeds[condition.body]()) for face in condition.where]
            rates = absorption_rates(field.grid, body.on_grid.functions, faces)
            self.external[self._fields.index(field)].absorption[:] += rates

    def begin(self, time: float, dt: float) -> None:
        """What acts over the step that begins at `time` [s]."""
        for field in self._fields:
            field.clear_external()
        for constraint in self._constraints:
            constraint.begin(time, dt)
        for body, condition, column in self._pressures:
            body.add_pressure(condition.at(time), column)
        self._forces.begin(time)

    def works(self) -> list[StepWork]:
        """What the constraints on points did over the step."""
        return [constraint.work(self._columns, self._n_supports) for constraint in self._constraints]
