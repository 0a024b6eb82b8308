"""From a case to its velocity fields: which bodies share one, and how fields meet."""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.bodies.material_points.model import MaterialPointsCase
from pellucid.bodies.membrane_model import MembraneCase
from pellucid.bodies.registry import ALONE, BODIES
from pellucid.conditions.walls import constrain_nodes
from pellucid.contact.model import Contact
from pellucid.contact.pairs import SLIP, STICK, Pair
from pellucid.errors import CaseError, Problem
from pellucid.geometry.crossing import crossing
from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField, VelocityFields

if TYPE_CHECKING:
    from pellucid.case import Case

DEPTH = 0.25  # of a cell, by which a point may lie inside another body and still count as beside it


def build_velocity_fields(case: "Case", transfer: Any) -> VelocityFields:
    """The bodies of a case on the nodes that they share: one set of nodes for each velocity field."""
    fields: dict[str, list[Any]] = {}
    for body in case.body:
        fields.setdefault(body.field, []).append(body)
    velocity_fields = VelocityFields()
    for field, members in fields.items():
        kinds = [(ALONE if len(members) == 1 else BODIES)[body.kind] for body in members]
        grid = Grid(case.grid, own_nodes=any(kind.own_nodes for kind in kinds))
        supports = constrain_nodes(grid, case.support)
        bodies = [kind(body.knowing(case.body), case.grid, grid, transfer) for kind, body in zip(kinds, members, strict=True)]
        velocity_fields.append(VelocityField(field, grid, bodies, supports))
    return velocity_fields


def pairs_of(velocity_fields: Sequence[VelocityField], contacts: Sequence[Contact]) -> list[Pair]:
    """Each two velocity_fields in the contact that is asked for, without friction where none is."""
    fields = {body.name: velocity_field.field for velocity_field in velocity_fields for body in velocity_field.bodies}
    asked = {tuple(fields[name] for name in contact.between): contact for contact in contacts}
    pairs = []
    for one, other in combinations(velocity_fields, 2):
        if (other.field, one.field) in asked:  # so that the first is the first named
            one, other = other, one
        contact = asked.get((one.field, other.field))
        if contact is None:
            pairs.append(_pair(one, other, SLIP))
        else:
            kind = STICK if contact.kind == "stick" else SLIP
            pairs.append(_pair(one, other, kind, contact.friction or 0.0, contact.name))
    return pairs


def _pair(one: VelocityField, other: VelocityField, kind: int, friction: float = 0.0, name: str | None = None) -> Pair:
    grids, outsides = (one.grid, other.grid), (one.outside, other.outside)
    return Pair(grids, (one.bodies, other.bodies), outsides, kind, friction, name)


def refuse_overlaps(case: "Case", velocity_fields: Sequence[VelocityField]) -> None:
    """Raise CaseError where a body starts inside one of another velocity field: nothing could tell which way out is."""
    cases: dict[str, Any] = {body.name: body for body in case.body}
    x, y, z = (not thin for thin in case.grid.thin())
    away = np.eye(3)[[x, y, z]]
    steps = np.vstack([np.zeros(3), away, -away]) * DEPTH * case.grid.cell
    for one, two in combinations(
        (body for velocity_field in velocity_fields for body in velocity_field.bodies if body.is_surface), 2
    ):
        if cases[one.name].field != cases[two.name].field:
            _refuse_crossing(cases[one.name], cases[two.name])
    for body, other in _strangers(velocity_fields):
        solid = cases[other.name]
        if not isinstance(solid, MaterialPointsCase):
            continue
        position = body.arrays["position"]
        if body.is_surface:  # its vertices may stand on both sides of a body that it cuts
            vertices, triangles = cases[body.name].surface.triangulate()
            position = np.concatenate([vertices, vertices[triangles].mean(axis=1)])
        inside = np.ones(len(position), bool)
        for step in steps:
            places = position[inside] + step
            kept = solid.shape.geometry().contains(places, (x, y, z))
            for left_out in solid.knowing(case.body).left_out:
                kept &= ~left_out.contains(places, (x, y, z))
            inside[inside] = kept
        if inside.any():
            place = ", ".join(f"{value:.4g}" for value in position[inside][0])
            text = (
                f"{int(inside.sum())} of {len(position)} points of it start inside body {other.name}, which belongs to another "
                f"velocity field, the first at ({place}) m: contact cannot tell which way out is"
            )
            leave_out = "" if body.is_surface else f"name {other.name} in `outside`, "
            remedy = f"move one of the two, {leave_out}or give both the same `field`"
            raise CaseError(Problem(text, f"body.{body.name}.{cases[body.name].place}", remedy=remedy))


def _refuse_crossing(one: MembraneCase, other: MembraneCase) -> None:
    found = crossing(one.surface.triangulate(), other.surface.triangulate())
    if found is not None:
        place = ", ".join(f"{value:.4g}" for value in found)
        text = (
            f"it crosses or touches body {other.name}, which belongs to another velocity field, for example at ({place}) m: "
            f"contact cannot tell on which side it is"
        )
        raise CaseError(Problem(text, f"body.{one.name}.surface", remedy="move one of the two, or give both the same `field`"))


def _strangers(velocity_fields: Sequence[VelocityField]) -> Iterator[tuple[Any, Any]]:
    for one in velocity_fields:
        for other in velocity_fields:
            if one.field != other.field:
                yield from ((body, stranger) for body in one.bodies for stranger in other.bodies)
