"""Bodies that start inside each other or cross.

Between velocity fields that is an error: contact could not find the normal. Within one there is the mass of both where two
volumes overlap: that is a warning.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations, permutations

import numpy as np

from pellucid.errors import CaseError, Problem
from pellucid.geometry.crossing import crossing
from pellucid.geometry.triangulation import Triangulation
from pellucid.grid.model import GridCase
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel

DEPTH = 0.25  # of a cell, by which a point may lie inside another body and still count as beside it
SAMPLES = 4000  # points of a body that are tested within a velocity field, at most


def refuse_overlaps(models: Sequence[BodyModel], bodies: Sequence[Body], grid: GridCase | None) -> None:
    """Raise CaseError where a body starts inside one of another velocity field, or two membranes of such cross."""
    if grid is None:  # without a grid they do not touch
        return
    known = {model.name: model.with_others(models) for model in models}
    for one, two in combinations(bodies, 2):
        if one.is_surface and two.is_surface and known[one.name].field != known[two.name].field:
            _refuse_crossing(one, two)
    for body, other in permutations(bodies, 2):
        if other.is_surface or known[body.name].field == known[other.name].field:
            continue
        position = body.arrays["position"]
        if body.is_surface:  # its vertices may stand on both sides of a body that it cuts
            position = body.places()
            position = np.concatenate([position, position[body.cells().surface()].mean(axis=1)])
        inside = _well_inside(position, known[other.name], grid)
        if inside.any():
            place = ", ".join(f"{value:.4g}" for value in position[inside][0])
            text = (
                f"{int(inside.sum())} of {len(position)} points of it start inside body {other.name}, which belongs to another "
                f"velocity field, the first at ({place}) m: contact cannot tell which way out is"
            )
            leave_out = "" if body.is_surface else f"name {other.name} in `outside`, "
            remedy = f"move one of the two, {leave_out}or give both the same `field`"
            raise CaseError(Problem(text, f"body.{body.name}.{known[body.name].place}", remedy=remedy))


def overlaps_within_fields(models: Sequence[BodyModel], bodies: Sequence[Body], grid: GridCase | None) -> Iterator[str]:
    """Warnings about volumes of one velocity field that overlap, one for each two of them."""
    if grid is None:
        return
    known = {model.name: model.with_others(models) for model in models}
    for body, other in combinations(bodies, 2):
        if body.is_surface or other.is_surface or known[body.name].field != known[other.name].field:
            continue
        position = body.arrays["position"]
        position = position[:: max(1, len(position) // SAMPLES)]
        inside = _well_inside(position, known[other.name], grid)
        if inside.any():
            place = ", ".join(f"{value:.4g}" for value in position[inside][0])
            yield (
                f"bodies {body.name} and {other.name} overlap in one velocity field, for example at ({place}) m: there is the "
                f"mass of both there; name one in `outside` of the other, or move one"
            )


def _well_inside(position: np.ndarray, model: BodyModel, grid: GridCase) -> np.ndarray:
    """Which positions lie inside a body, and no nearer to its border than DEPTH of a cell along any axis."""
    x, y, z = (not thin for thin in grid.thin())
    away = np.eye(3)[[x, y, z]]
    inside = np.ones(len(position), bool)
    for step in np.vstack([np.zeros(3), away, -away]) * DEPTH * grid.cell:
        inside[inside] = model.contains(position[inside] + step, (x, y, z))
    return inside


def _refuse_crossing(one: Body, other: Body) -> None:
    found = crossing(*(Triangulation(body.places(), body.cells().surface()) for body in (one, other)))
    if found is not None:
        place = ", ".join(f"{value:.4g}" for value in found)
        text = (
            f"it crosses or touches body {other.name}, which belongs to another velocity field, for example at ({place}) m: "
            f"contact cannot tell on which side it is"
        )
        raise CaseError(Problem(text, f"body.{one.name}.surface", remedy="move one of the two, or give both the same `field`"))
