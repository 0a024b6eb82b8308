"""From a case to its bodies, the velocity fields that they share, and the pairs of these in contact."""

from collections.abc import Collection, Mapping, Sequence
from itertools import combinations, product
from typing import TYPE_CHECKING

from pellucid.approximants import GridFunctions
from pellucid.conditions.contact import Contact
from pellucid.contact.contact_body import ContactBody
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.impulses import SLIP, STICK
from pellucid.contact.overlap import coefficient, swing_of
from pellucid.contact.pairs import ContactPair
from pellucid.contact.surface_pairs import SurfacePair
from pellucid.grid.full_cells import CellPressure, Filling
from pellucid.grid.lattice import Grid
from pellucid.grid.own_nodes_field import OwnNodesField
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import Flip, VelocityTransfer
from pellucid.parts.body import Body, Placement
from pellucid.parts.body_model import BodyModel
from pellucid.parts.families import GridBody

if TYPE_CHECKING:
    from pellucid.case import Case

POINTS_PER_THREAD = 10_000  # with which a run begins, until it knows better
Built = dict[str, tuple[Body, VelocityField | None]]
"""Bodies by name, each with the velocity field that it is in; there is none without a grid."""
Surfaces = Mapping[str, ContactSurface | None]
"""Those of bodies by name, None of one that has none."""


def _models_by_field(case: "Case") -> dict[str, list[BodyModel]]:
    members: dict[str, list[BodyModel]] = {}
    for model in case.body:
        members.setdefault(model.field, []).append(model)
    return members


def build_bodies(case: "Case", transfer: VelocityTransfer, n_loads: int) -> tuple[list[VelocityField], Built]:
    """The velocity fields of a case and its bodies, on which so many channels of external forces act."""
    members = _models_by_field(case)
    fields, built = list[VelocityField](), Built()
    if case.grid_or_none is None:
        placement = Placement(None, None, transfer, case.gravity, n_loads)
        return [], {model.name: (model.with_others(case.body).build(placement), None) for model in case.body}
    for name, models in members.items():
        own = [model.owns_nodes(len(models) == 1) for model in models]
        field = (OwnNodesField if all(own) else VelocityField)(name, Grid(case.grid))
        fields.append(field)
        # nothing of a rigid motion is to be smoothed: with PIC or APIC a rigid body would lose its spin
        own_transfer = Flip() if all(model.is_rigid for model in models) else transfer
        placement = Placement(case.grid, field, own_transfer, case.gravity, n_loads)
        for model in models:
            built[model.name] = model.with_others(case.body).build(placement), field
    return fields, built


def cell_pressures(fields: Mapping[VelocityField, Sequence[GridBody]]) -> list[CellPressure]:
    """Those of the fluids in each velocity field, together as far as they share forces and functions."""
    groups: dict[tuple[VelocityField, GridFunctions, int], list[Filling]] = {}
    for field, bodies in fields.items():
        for fluid in (body.filling for body in bodies):
            if fluid is not None:
                groups.setdefault((field, fluid.functions, fluid.nodal_forces.ctypes.data), []).append(fluid)
    return [CellPressure(field.grid, fluids) for (field, *_), fluids in groups.items()]


def may_touch_by_surfaces(case: "Case") -> bool:
    """Whether two velocity fields may: both of material points that do not flow, or one of bodies that do not deform, as they
    are rigid or motions lead them."""
    led = {model.name for model in case.body if model.is_rigid} | {motion.body for motion in case.motion}
    members = list(_models_by_field(case).values())
    soft = sum(all(model.deforms_in_contact for model in models) for models in members)
    return soft > 1 or (len(members) > 1 and any(all(model.name in led for model in models) for models in members))


def surfaces_of(case: "Case", built: Built, names: Collection[str], column: int | None) -> Surfaces:
    """Make the surfaces of bodies by which others touch them; column: of the work of forces between surfaces."""
    if column is None:
        return {}
    surfaces = {name: built[name][0].make_contact_surface(column) for name in built if name in names}
    ends = [("xyz".index(face[0]), face.endswith("upper")) for outflow in case.outflow for face in outflow.faces]
    open_faces = [(axis, float((case.grid.extent_upper() if upper else case.grid.lower)[axis])) for axis, upper in ends]
    for surface in surfaces.values():
        if surface is not None:
            surface.end_at(open_faces)
    return surfaces


def pairs_of(
    fields: Sequence[VelocityField],
    built: Built,
    contacts: Sequence[Contact],
    surfaces: Surfaces,
    gravity: float,
    courant: float,
) -> tuple[list[ContactPair], list[SurfacePair]]:
    """Every two velocity fields with the contact of the case; without friction where it names none.

    gravity: largest [m/s²]; courant: of the case. Two fields touch by their surfaces where all of their bodies have one that
    serves, and not all are membranes, whose sides tell nothing of each other; else on the nodes of the grid.
    """
    members = {field: [body for body, own in built.values() if own is field] for field in fields}
    named = {tuple(built[name][1] for name in contact.between): contact for contact in contacts}
    pairs, touching = [], []
    for one, other in combinations(fields, 2):
        if (other, one) in named:  # so that the first is the first named
            one, other = other, one
        contact = named.get((one, other))
        found = [[surfaces.get(body.name) for body in members[field]] for field in (one, other)]
        known = [surface for surface in (*found[0], *found[1]) if surface is not None]
        if (
            len(known) == len(found[0]) + len(found[1])
            and all(surface.is_hard or surface.serves_deformed for surface in known)
            and not all(surface.two_sided for surface in known)
        ):
            touching += _surface_pairs(one.grid, found, contact, gravity, courant)
        else:
            met = {field: [body.met for body in bodies if body.met] for field, bodies in members.items()}
            pairs.append(_pair((one, other), met, contact))
    return pairs, touching


def _surface_pairs(
    grid: Grid, found: Sequence[Sequence[ContactSurface | None]], contact: Contact | None, gravity: float, courant: float
) -> list[SurfacePair]:
    friction, name = 0.0, None
    if contact is not None:
        friction, name = coefficient(contact.kind, contact.friction), contact.name
    dimension = 2 - sum(grid.thin)
    pairs = []
    for one, other in product(*found):
        if one is not None and other is not None:
            swing = swing_of(grid.lattice.cell, gravity, one.speed() + other.speed())
            how = friction, dimension, grid.slice_thickness, courant, swing, name, grid.lattice.cell
            pairs.append(SurfacePair((one, other), *how))
    return pairs


def _pair(
    fields: tuple[VelocityField, VelocityField],
    bodies: Mapping[VelocityField, Sequence[ContactBody]],
    contact: Contact | None,
) -> ContactPair:
    sides = bodies[fields[0]], bodies[fields[1]]
    if contact is None:
        return ContactPair(fields, sides, SLIP)
    kind = STICK if contact.kind == "stick" else SLIP
    return ContactPair(fields, sides, kind, contact.friction or 0.0, contact.name)


def worthwhile_threads(bodies: Sequence[Body]) -> int:
    """Threads that bodies of this size keep busy on most machines."""
    return max(1, sum(body.n_stress_points for body in bodies) // POINTS_PER_THREAD)
