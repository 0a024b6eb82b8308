"""Checks for bodies that start inside each other or intersect.

Between velocity fields this is an error, because contact could not find the normal. Within one velocity field, an overlap
of two volumes contains the mass of both; this is a warning. A body that continues from an earlier run is located by its
points, not by its description in the case. Two bodies that both continue are not checked again.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from collections.abc import Set as AbstractSet
from itertools import product

import numpy as np

from pellucid.bodies.membranes.model import MembraneCase
from pellucid.case import Case
from pellucid.errors import CaseError, Problem
from pellucid.geometry.meshes.triangulation import Triangulation, bounding_box
from pellucid.geometry.region import images
from pellucid.grid.model import GridCase
from pellucid.parts.body_model import BodyModel, Standing

DEPTH = 0.25  # largest depth of a point inside another body that is accepted, in cells
SAMPLES = 4000  # points of a body that are tested within a velocity field, at most

Contains = Callable[[np.ndarray], np.ndarray]
"""Function of positions [m], shape (n, 3), that returns a mask of the positions inside a body, shape (n,)."""


def refuse_overlaps(
    models: Sequence[BodyModel],
    standing: Mapping[str, Standing],
    grid: GridCase | None,
    going_on: AbstractSet[str] = frozenset(),
) -> None:
    """Raise CaseError if a body starts inside a body of another velocity field, or if membranes of different fields
    intersect.

    standing: initial points of the bodies, by name; other bodies are not checked. going_on: names of the bodies that
    continue from an earlier run.
    """
    if grid is None:  # without a grid they do not touch
        return
    near = _near(models, standing, grid, going_on)
    for one, two in near:
        if one.is_surface and two.is_surface and one.field != two.field:
            _refuse_crossing(one, two, standing, grid)
    for body, other in [*near, *((two, one) for one, two in near)]:
        if other.is_surface or body.field == other.field:
            continue
        position, triangles, _ = standing[body.name]
        if triangles is not None:  # the vertices may lie on both sides of a body that the surface cuts
            position = np.concatenate([position, position[triangles].mean(axis=1)])
        inside = _well_inside(position, _contents(other, standing[other.name], grid, going_on), grid)
        if inside.any():
            place = ", ".join(f"{value:.4g}" for value in position[inside][0])
            text = (
                f"{int(inside.sum())} of {len(position)} points of this body start inside body {other.name} of another "
                "velocity "
                f"field, the first at ({place}) m: the contact direction is undefined"
            )
            leave_out = "" if body.is_surface else f"list {other.name} in `outside`, "
            remedy = f"Move one of the two, {leave_out}or set the same `field` for both."
            raise CaseError(Problem(text, f"body.{body.name}.{body.place}", remedy=remedy))


def overlaps_within_fields(
    models: Sequence[BodyModel],
    standing: Mapping[str, Standing],
    grid: GridCase | None,
    going_on: AbstractSet[str] = frozenset(),
) -> Iterator[str]:
    """Yield a warning for each pair of bodies of one velocity field whose volumes overlap.

    models: bodies of the case; standing: initial points of the bodies, by name; grid: table of the grid; going_on: names of
    the bodies that continue from an earlier run.
    """
    if grid is None:
        return
    for body, other in _near(models, standing, grid, going_on):
        if body.is_surface or other.is_surface or body.field != other.field:
            continue
        position = standing[body.name].position
        position = position[:: max(1, len(position) // SAMPLES)]
        inside = _well_inside(position, _contents(other, standing[other.name], grid, going_on), grid)
        if inside.any():
            place = ", ".join(f"{value:.4g}" for value in position[inside][0])
            yield (
                f"bodies {body.name} and {other.name} overlap in one velocity field, for example at ({place}) m: the overlap "
                f"contains the mass of both. List one in `outside` of the other, or move one."
            )


def _near(
    models: Sequence[BodyModel], standing: Mapping[str, Standing], grid: GridCase, going_on: AbstractSet[str]
) -> list[tuple[BodyModel, BodyModel]]:
    """Return the pairs of bodies whose bounding boxes are less than a cell apart, except pairs of two bodies that continue
    from an earlier run. Arguments as in `refuse_overlaps`."""
    known = [model.with_others(models) for model in models if model.name in standing]
    if len(known) < 2:
        return []
    boxes = [bounding_box(standing[model.name].position) if model.name in going_on else model.bounds() for model in known]
    lower, upper = (np.array(ends)[:, ~np.array(grid.thin())] for ends in zip(*boxes, strict=True))
    folds = np.array(grid.is_periodic())[~np.array(grid.thin())]  # along these any two may meet across the seam
    meet = ((lower[:, None] <= upper[None] + grid.cell) | folds).all(axis=2)
    pairs = np.argwhere(np.triu(meet & meet.T, 1)).tolist()
    return [(known[i], known[j]) for i, j in pairs if not {known[i].name, known[j].name} <= going_on]


def _contents(model: BodyModel, standing: Standing, grid: GridCase, going_on: AbstractSet[str]) -> Contains:
    """Return a function that tests which positions [m], shape (n, 3), lie inside a body.

    standing: initial points of the body; going_on: names of the bodies that continue from an earlier run. The region of the
    body is its shape or, if the body continues from an earlier run, the union of cubes with the volumes of its points.
    """
    active = np.array(grid.active_axes())
    if model.name not in going_on or standing.volume is None:
        return lambda places: model.contains(places, grid.active_axes(), grid.periods())
    from scipy.spatial import cKDTree

    size = standing.volume / grid.slice_thickness() ** np.count_nonzero(~active)
    half = 0.5 * size ** (1.0 / np.count_nonzero(active))
    tree = cKDTree(standing.position[:, active])

    def contains(places: np.ndarray) -> np.ndarray:
        distance, nearest = tree.query(places[:, active], p=np.inf)
        return np.asarray(distance <= half[nearest])

    return contains


def _well_inside(position: np.ndarray, contains: Contains, grid: GridCase) -> np.ndarray:
    """Return a mask, shape (n,), of the positions [m], shape (n, 3), that lie inside a body by more than DEPTH cells along
    axes and diagonals; contains: function that tests which positions lie in the body.

    From a position on an edge of a region that the body leaves out, steps along the axes stay in faces of the region,
    where rounding decides the result; a diagonal step leads into the region.
    """
    steps = np.array(list(product(*((0.0,) if thin else (0.0, 1.0, -1.0) for thin in grid.thin()))))
    steps /= np.maximum(np.linalg.norm(steps, axis=1, keepdims=True), 1.0)
    inside = np.ones(len(position), bool)
    for step in steps * DEPTH * grid.cell:
        inside[inside] = contains(position[inside] + step)
    return inside


def _refuse_crossing(one: BodyModel, other: BodyModel, standing: Mapping[str, Standing], grid: GridCase) -> None:
    from pellucid.geometry.meshes.crossing import crossing  # heavy

    (first, one_triangles, _), (second, other_triangles, _) = standing[one.name], standing[other.name]
    if one_triangles is None or other_triangles is None:
        return
    ways = images(grid.periods(), bounding_box(first), bounding_box(second))
    there = Triangulation(second, other_triangles)
    found = next((at for way in ways if (at := crossing(Triangulation(first + way, one_triangles), there)) is not None), None)
    if found is not None:
        place = ", ".join(f"{value:.4g}" for value in found)
        text = (
            f"this body intersects or touches body {other.name} of another velocity field, for example at ({place}) m: "
            f"the sides in contact are undefined"
        )
        gap = f"{0.01 * grid.cell:.2g} m"
        remedy = f"Move one of the two until there is a gap ({gap} is enough). To join them, set the same `field` for both."
        raise CaseError(Problem(text, f"body.{one.name}.surface", remedy=remedy))


def contact_offsets(case: Case) -> list[str]:
    """Return a line of text for each membrane that may be in contact with other bodies or walls: the distance from its
    surface at which contact starts, and the reason for this distance."""
    if case.grid_or_none is None or not (case.wall or len({body.field for body in case.body}) > 1):
        return []
    return [_line(body) for body in case.body if isinstance(body, MembraneCase)]


def _line(body: MembraneCase) -> str:
    why = "half the thickness" if body.contact_offset is None else "`contact_offset`"
    offset = "" if body.contact_offset is None else f"; the thickness is {body.thickness:.4g} m"
    return f"contact: faces of membrane {body.name} are {body.contact_reach:.4g} m from `surface` on both sides ({why}{offset})"
