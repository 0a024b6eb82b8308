"""Construction of the bodies of a case, of the velocity fields that they share, and of the parts that conditions add to a step;
initial positions of bodies, and loading of the state of an earlier run into bodies that continue from it."""

import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.approximants import NO_ENDS
from pellucid.case.probe import COLUMNS
from pellucid.case.sections import parts_of
from pellucid.conditions.support import on_each_face
from pellucid.conditions.symmetry import mirrored_ends
from pellucid.energy import (
    CONTACT_WORK,
    DAMPING_HEAT,
    FIXED_COLUMNS,
    INFLOW_ENERGY,
    INFLOW_WORK,
    MASS_MATRIX_WORK,
    OUTFLOW_ENERGY,
    OUTFLOW_WORK,
    TRANSFER_HEAT,
    WorkLayout,
    channel_of_load,
)
from pellucid.errors import CaseError, Problem
from pellucid.grid.actions import NodalActions
from pellucid.grid.lattice import Grid
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import Flip, VelocityTransfer
from pellucid.parts.assembly import AssembledBody, Assembly, of_class
from pellucid.parts.body import Body, Placement, in_metres
from pellucid.parts.body_model import BodyModel, Standing
from pellucid.parts.capabilities import GainsPoints
from pellucid.parts.condition import Condition
from pellucid.simulation.ranks import cut_rows
from pellucid.step.part import StepPart, StepParts

if TYPE_CHECKING:
    from pellucid.case import Case


STANDARD = frozenset({*FIXED_COLUMNS, MASS_MATRIX_WORK, INFLOW_ENERGY, INFLOW_WORK, OUTFLOW_ENERGY, OUTFLOW_WORK})
"""Channels whose names are reserved for the conditions of the package."""
NAME, LOAD_NAME = re.compile(r"[a-z][a-z0-9_]*_(work|heat|energy)"), re.compile(r"[a-z][a-z0-9_]*_work")
POINTS_PER_THREAD = 10_000  # points per thread, for the initial number of threads of a run
Built = dict[str, tuple[Body, VelocityField | None]]
"""Bodies by name, each with its velocity field, or None without a grid."""


def models_by_field(case: "Case") -> dict[str, list[BodyModel]]:
    """Return the models of the bodies of a case, grouped by the name of their velocity field; bodies that act as walls of the
    fluids in their velocity field form a group of their own."""
    members: dict[str, list[BodyModel]] = {}
    for model in case.body:
        members.setdefault(model.nodes_of, []).append(model)
    return members


def build_bodies(case: "Case", transfer: VelocityTransfer, n_loads: int) -> tuple[list[VelocityField], Built]:
    """Build the bodies of a case and the velocity fields (sets of grid nodes that bodies share) to which they belong;
    return the fields, and the bodies as a `Built`.

    transfer: velocity transfer between points and grid; n_loads: number of channels of external forces, i.e. entries for
    the work of these forces in the energy balance.
    """
    members = models_by_field(case)
    fields, built = list[VelocityField](), Built()
    if case.grid_or_none is None:
        placement = Placement(None, None, transfer, case.gravity, n_loads)
        return [], {model.name: (model.with_others(case.body).build(placement), None) for model in case.body}
    owned = {name: all(model.owns_nodes(len(models) == 1) for model in models) for name, models in members.items()}
    conditions = [one for several in case.conditions().values() for one in several]
    # bodies with their own nodes count the impulses of supports on these nodes alone; an airbag was less accurate with mirrors
    as_walls = any(owned.values()) or any(model.is_surface for model in case.body)
    # without shear stress, motion along a plane has no slope to be kept, and the loops over the points beside it take longer
    as_walls |= not any(model.shear_viscosity > 0.0 or not (model.is_fluid or model.is_rigid) for model in case.body)
    mirrored = NO_ENDS if as_walls else mirrored_ends(case.support, conditions, case.grid, case.gravity)
    for name in members:
        fields.append((OwnNodesField if owned[name] else VelocityField)(name, Grid(case.grid, mirrored)))
    cut_rows(case.body, case.grid, fields[0].grid)
    for field, models in zip(fields, members.values(), strict=True):
        # nothing of a rigid motion is to be smoothed: with PIC or APIC a rigid body would lose its spin
        own_transfer = Flip() if all(model.is_rigid for model in models) else transfer
        placement = Placement(case.grid, field, own_transfer, case.gravity, n_loads)
        for model in models:
            built[model.name] = model.with_others(case.body).build(placement), field
    return fields, built


def has_several_fields(case: "Case") -> bool:
    """Return True if a case has several velocity fields (sets of grid nodes that move independently), whose bodies may be in
    contact."""
    return case.grid_or_none is not None and len({body.field for body in case.body}) > 1


def _may_touch_by_surfaces(case: "Case") -> bool:
    """Return True if surfaces of bodies in a case may touch each other or walls (contact by surfaces instead of on grid
    nodes)."""
    if case.grid_or_none is None:
        return False
    touches_itself = any(contact.is_of_one_body for contact in case.contact)
    return len(case.wall) > 0 or touches_itself or (has_several_fields(case) and _fields_may(case))


def _fields_may(case: "Case") -> bool:
    """Return True if bodies of two velocity fields may be in contact by their surfaces. This requires that at least one
    body of each field has a contact surface, is rigid or follows a prescribed motion."""
    led = {model.name for model in case.body if model.is_rigid} | {motion.body for motion in case.motion}
    members = models_by_field(case).values()
    return sum(any(model.deforms_in_contact or model.name in led for model in models) for models in members) > 1


def work_layout(case: "Case") -> WorkLayout:
    """Return the layout of the arrays of works in a run, i.e. which column belongs to which entry of the energy balance.
    Raises CaseError for a channel with an invalid name."""
    touches = has_several_fields(case) or any(contact.is_of_one_body for contact in case.contact)
    columns = [*([CONTACT_WORK] if touches else []), *([DAMPING_HEAT] if case.steady else [])]
    columns += [TRANSFER_HEAT] if case.grid_or_none is not None else []
    columns += [MASS_MATRIX_WORK] if case.time.mass_matrix == "consistent" else []
    columns += [channel for body in case.body for channel in body.channels()]
    every = [condition for several in case.conditions().values() for condition in several]
    for condition in every:
        _check_channels(condition)
    loads = [channel_of_load(name) for condition in every if (name := condition.load_channel()) is not None]
    stated = [channel for condition in every for channel in condition.channels()]
    return WorkLayout(loads, [*stated, *columns], len(on_each_face(case.support)), _may_touch_by_surfaces(case))


def _check_channels(condition: Condition) -> None:
    """Raise CaseError if a channel of a condition has a name that cannot be a column of the history, or that another column
    of the history has."""
    load = condition.load_channel()
    named = [channel_of_load(load)] if load is not None else []
    for channel in (*named, *condition.channels()):
        is_load = channel in named
        reserved = channel.name in COLUMNS and (channel not in STANDARD or (is_load and channel in FIXED_COLUMNS))
        ends = LOAD_NAME if is_load else NAME
        if reserved or not ends.fullmatch(channel.name):
            what = "load channel" if is_load else "channel"
            text = f"{of_class(type(condition))} has the {what} `{channel.name}` of the energy balance"
            why = ", but another column of the history has this name" if reserved else ", which is not a valid name"
            end = "`_work`" if is_load else "`_work`, `_heat` or `_energy`"
            remedy = f"Choose another name of lower-case letters, digits and underscores that ends in {end}."
            raise CaseError(Problem(text + why, remedy=remedy))


def activate_conditions(case: "Case", built: Built, actions: Sequence[NodalActions], layout: WorkLayout) -> StepParts:
    """Activate all conditions of a case, complete its bodies, and return the parts of a step that the conditions add.

    built: the bodies, by name, with their velocity fields; actions: for each velocity field the object through which
    conditions act on its nodes; layout: order of the works. Raises CaseError if `activate` of a condition returns anything
    else than parts.
    """
    if layout.surface_contact is not None:
        for each in actions:
            each.take_loads()
    of = {each.field: each for each in actions}
    members: dict[str, AssembledBody] = {}
    for model in case.body:
        body, field = built[model.name]
        members[model.name] = AssembledBody(body, model.with_others(case.body), None if field is None else of[field])
    finds_equilibria = case.steady is not None and case.steady.is_factored(parts_of(case))
    assembly = Assembly(members, actions, layout, finds_equilibria=finds_equilibria)
    parts = StepParts()
    for kind, conditions in case.conditions().items():
        found: object = kind.activate(conditions, assembly._replace(active=kind))
        if not isinstance(found, Sequence) or not all(isinstance(part, StepPart) for part in found):
            text = f"`activate` of {of_class(kind)} returns {found!r}"
            raise CaseError(Problem(text, remedy="Return a list of objects of classes derived from `StepPart`."))
        parts.add(found)
    for member in members.values():
        member.body.complete()
    parts.try_out()
    return parts


def worthwhile_threads(bodies: Sequence[Body]) -> int:
    """Return a number of threads for which these bodies have enough points to gain from more threads on most machines."""
    return max(1, sum(body.n_stress_points for body in bodies) // POINTS_PER_THREAD)


class Standings(Mapping[str, Standing]):
    """Mapping from body names to initial positions (`Standing`), each computed when requested."""

    def __init__(self, bodies: Sequence[Body], going_on: Collection[str]) -> None:
        """bodies: all bodies; going_on: names of the bodies that start in the state of an earlier run."""
        self._bodies, self._going_on = {body.name: body for body in bodies}, going_on

    def __getitem__(self, name: str) -> Standing:
        body = self._bodies[name]
        if body.is_surface:
            return Standing(body.places(), body.cells().surface())
        return Standing(body.stored_array("position"), volume=body.volumes() if name in self._going_on else None)

    def __contains__(self, name: object) -> bool:
        return name in self._bodies

    def __iter__(self) -> Iterator[str]:
        return iter(self._bodies)

    def __len__(self) -> int:
        return len(self._bodies)


def load_state(built: Built, start: Mapping[str, Mapping[str, np.ndarray]]) -> None:
    """Load the arrays of an earlier run into bodies that continue from this run, before conditions act on them. Raises
    `CaseError` if the arrays do not fit.

    built: all bodies, by name; start: arrays of the bodies that continue, by body name and array name.
    """
    for name, state in start.items():
        body, field = built[name]
        more = len(state["id"]) - body.n_points
        if more > 0 and isinstance(body, GainsPoints) and not np.all(state["mass"]):  # rows for points that enter
            body.make_room(more, body.stored_array("position").mean(axis=0))
        if len(state["id"]) != body.n_points:
            text = f"body {name} has {body.n_points} points, but {len(state['id'])} in the earlier run"
            remedy = "Define the body as in the earlier run, or remove it from start.body."
            raise CaseError(Problem(text, "start.path", remedy=remedy))
        if field is not None:
            _check_inside(name, state["position"], field.grid)
        _give(body, state)


def _give(body: Body, state: Mapping[str, np.ndarray]) -> None:
    try:
        body.load_state(state)
    except KeyError as missing:
        text = f"body {body.name} requires {missing.args[0]}, which is not stored in the earlier run"
        remedy = (
            "Remove start.time (checkpoints contain more than frames), or use the kind and the material of the earlier run."
        )
        raise CaseError(Problem(text, "start", remedy=remedy)) from None


def _check_inside(name: str, position: np.ndarray, grid: Grid) -> None:
    lower = np.array(grid.lattice.lower)
    upper = lower + np.array(grid.lattice.counts) * grid.lattice.cell
    walled = ~(np.array(grid.thin) | np.array(grid.periodic))
    outside = np.flatnonzero((((position < lower) | (position > upper)) & walled).any(axis=1))
    if len(outside):
        text = f"{len(outside)} points of body {name} are outside the grid, for example number {outside[0]} at"
        raise CaseError(
            Problem(
                f"{text} {in_metres(position[outside[0]])}", "start.path", remedy="Enlarge the grid to contain these points."
            )
        )
