"""Bodies of different velocity fields that start inside each other or cross: contact could not tell which way out is."""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import TYPE_CHECKING, Any

import numpy as np

from pellucid.bodies.contract import Body
from pellucid.bodies.models import MaterialPointsCase, Membrane
from pellucid.errors import CaseError, Problem
from pellucid.geometry.crossing import crossing

if TYPE_CHECKING:
    from pellucid.case import Case

DEPTH = 0.25  # of a cell, by which a point may lie inside another body and still count as beside it


def refuse_overlaps(case: "Case", bodies: Sequence[Body]) -> None:
    """Raise CaseError where a body starts inside one of another velocity field: nothing could tell which way out is."""
    cases: dict[str, Any] = {body.name: body for body in case.body}
    x, y, z = (not thin for thin in case.grid.thin())
    away = np.eye(3)[[x, y, z]]
    steps = np.vstack([np.zeros(3), away, -away]) * DEPTH * case.grid.cell
    for one, two in combinations((body for body in bodies if body.is_surface), 2):
        if cases[one.name].field != cases[two.name].field:
            _refuse_crossing(cases[one.name], cases[two.name])
    for body, other in _strangers(cases, bodies):
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


def _refuse_crossing(one: Membrane, other: Membrane) -> None:
    found = crossing(one.surface.triangulate(), other.surface.triangulate())
    if found is not None:
        place = ", ".join(f"{value:.4g}" for value in found)
        text = (
            f"it crosses or touches body {other.name}, which belongs to another velocity field, for example at ({place}) m: "
            f"contact cannot tell on which side it is"
        )
        raise CaseError(Problem(text, f"body.{one.name}.surface", remedy="move one of the two, or give both the same `field`"))


def _strangers(cases: dict[str, Any], bodies: Sequence[Body]) -> Iterator[tuple[Body, Body]]:
    for one in bodies:
        yield from ((one, other) for other in bodies if cases[one.name].field != cases[other.name].field)
