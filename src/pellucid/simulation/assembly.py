"""Construction of the bodies of a case and of the velocity fields that they share."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

from pellucid.approximants import GridFunctions
from pellucid.conditions.active import layout_of
from pellucid.energy import CONTACT_WORK, DAMPING_HEAT, TRANSFER_HEAT, WorkLayout
from pellucid.grid.full_cells import CellPressure, Filling
from pellucid.grid.implicit_viscosity import ImplicitViscosity
from pellucid.grid.lattice import Grid
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import Flip, VelocityTransfer
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.families import GridBody
from pellucid.parts.placement import Placement
from pellucid.simulation.ranks import cut_rows

if TYPE_CHECKING:
    from pellucid.case import Case

POINTS_PER_THREAD = 10_000  # points per thread, for the initial number of threads of a run
Built = dict[str, tuple[Body, VelocityField | None]]
"""Bodies by name, each with its velocity field, or None without a grid."""


def models_by_field(case: "Case") -> dict[str, list[BodyModel]]:
    """Return the models of the bodies of a case, grouped by the name of their velocity field."""
    members: dict[str, list[BodyModel]] = {}
    for model in case.body:
        members.setdefault(model.field, []).append(model)
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
    for name, models in members.items():
        own = [model.owns_nodes(len(models) == 1) for model in models]
        fields.append((OwnNodesField if all(own) else VelocityField)(name, Grid(case.grid)))
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


def work_layout(case: "Case", touching: bool) -> WorkLayout:
    """Return the layout of the arrays of works in a run, i.e. which column belongs to which entry of the energy balance;
    touching: True if surfaces may be in contact."""
    touches = has_several_fields(case) or any(contact.is_of_one_body for contact in case.contact)
    columns = [*([CONTACT_WORK] if touches else []), *([DAMPING_HEAT] if case.steady else [])]
    columns += [TRANSFER_HEAT] if case.grid_or_none is not None else []
    return layout_of(case, [*columns, *(channel for body in case.body for channel in body.channels())], touching=touching)


def cell_pressures(fields: Mapping[VelocityField, Sequence[GridBody]]) -> list[CellPressure]:
    """Return the objects that compute mean pressures of full cells (cells that a fluid fills), for each velocity field with
    its bodies; one object serves all fluids of a field with the same nodal forces and shape functions."""
    groups: dict[tuple[VelocityField, GridFunctions, int], list[Filling]] = {}
    for field, bodies in fields.items():
        for fluid in (body.filling for body in bodies):
            if fluid is not None:
                groups.setdefault((field, fluid.functions, fluid.nodal_forces.ctypes.data), []).append(fluid)
    return [CellPressure(field.grid, fluids) for (field, *_), fluids in groups.items()]


def implicit_viscosities(fields: Mapping[VelocityField, Sequence[GridBody]]) -> list[ImplicitViscosity]:
    """Return the solvers of implicit viscosity, one for each velocity field that contains fluids with implicit viscosity."""
    solved = {field: [body.viscous for body in bodies if body.viscous is not None] for field, bodies in fields.items()}
    return [ImplicitViscosity(field, fluids) for field, fluids in solved.items() if fluids]


def worthwhile_threads(bodies: Sequence[Body]) -> int:
    """Return a number of threads for which these bodies have enough points to gain from more threads on most machines."""
    return max(1, sum(body.n_stress_points for body in bodies) // POINTS_PER_THREAD)
