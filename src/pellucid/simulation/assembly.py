"""From a case to its bodies: the velocity fields that they share, and how these touch."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import TYPE_CHECKING

from pellucid.bodies.contract import Body
from pellucid.bodies.registry import BODIES, BODIES_ALONE
from pellucid.conditions.acting import load_channels
from pellucid.contact.impulses import SLIP, STICK
from pellucid.contact.model import Contact
from pellucid.contact.pairs import ContactPair
from pellucid.contact.surface import ContactBody
from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField
from pellucid.grid.velocity_transfer import VelocityTransfer

if TYPE_CHECKING:
    from pellucid.case import Case

Built = dict[str, tuple[Body, VelocityField]]
"""Bodies by name, each with the velocity field that it is in."""


def build_bodies(case: "Case", transfer: VelocityTransfer) -> tuple[list[VelocityField], Built]:
    """The velocity fields of a case and its bodies; a body with its own nodes has a field to itself."""
    members: dict[str, list[str]] = {}
    for body in case.body:
        members.setdefault(body.field, []).append(body.name)
    n_loads, fields, built = len(load_channels(case)), [], Built()
    for name, names in members.items():
        alone = len(names) == 1
        own = [body for body in case.body if body.name in names]
        moves_points = not (alone and own[0].kind in BODIES_ALONE)
        field = VelocityField(name, Grid(case.grid), moves_points)
        fields.append(field)
        for model in own:
            if moves_points:
                built[model.name] = BODIES[model.kind](model.knowing(case.body), case.grid, field, transfer), field
            else:
                built[model.name] = BODIES_ALONE[model.kind](model, case.grid, field, case.gravity, n_loads), field
    return fields, built


def pairs_of(fields: Sequence[VelocityField], built: Built, contacts: Sequence[Contact]) -> list[ContactPair]:
    """Each two velocity fields in the contact that is asked for, without friction where none is."""
    bodies = {field: [body.on_grid for body, home in built.values() if home is field and body.on_grid] for field in fields}
    asked = {tuple(built[name][1] for name in contact.between): contact for contact in contacts}
    pairs = []
    for one, other in combinations(fields, 2):
        if (other, one) in asked:  # so that the first is the first named
            one, other = other, one
        pairs.append(_pair((one, other), bodies, asked.get((one, other))))
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
