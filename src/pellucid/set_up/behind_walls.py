"""Space behind plane walls: refuse bodies that start behind a wall, and extend the grid for points that need space behind a
wall."""

from collections.abc import Set as AbstractSet

import numpy as np

from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.conditions.absorbing import Absorbing
from pellucid.conditions.wall import Wall
from pellucid.errors import CaseError, Problem
from pellucid.grid.model import GridCase
from pellucid.parts.condition import Condition, is_driven
from pellucid.set_up.gaps import hard_bodies
from pellucid.set_up.overlap import DEPTH

ROOM = 1.0  # in cells, of the grid behind a wall: bodies press less deep into it
FACING = 0.5  # of 1, the least cosine between the normal of a wall and that of a face that it lies before
TINY, ROUNDING = 1e-9, 1e-6  # of a cell
MOST_PLACES = 100  # along an edge of a face, at which the depth of walls before it is sampled
REMEDY = (
    "Move the body or the wall, set `normal` to point to the side of the bodies, "
    "or list in `bodies` only the bodies that the wall acts on."
)


def refuse_behind_walls(case: Case, going_on: AbstractSet[str] = frozenset()) -> None:
    """Raise CaseError if a body starts behind a wall (a rigid plane of the case) that acts on it.

    going_on: names of the bodies that continue from an earlier run; they are not checked.
    """
    if case.grid_or_none is None:
        return
    parts, hard = parts_of(case), {body.name for body in hard_bodies(case)}
    for number, wall in enumerate(case.wall):
        plane, most = wall.plane(), DEPTH * case.grid.cell
        for body in wall.touching(case.body):
            if body.name in going_on or is_driven(body.name, parts):  # a motion leads it through
                continue
            places = body.with_others(case.body).touching_places(case.grid, body.name in hard)
            depth = -plane.height(places)
            if len(depth) and depth.max() > most:
                deepest = int(depth.argmax())
                place = ", ".join(f"{value:.4g}" for value in places[deepest])
                text = (
                    f"body {body.name} starts {depth[deepest]:.4g} m behind this wall, at ({place}) m; "
                    f"the limit is a quarter of a cell, {most:.4g} m"
                )
                raise CaseError(Problem(text, f"wall.{wall.name or number}.point", remedy=REMEDY))


def with_room_behind_walls(case: Case) -> Case:
    """Return the case. If a plane wall lies on or close in front of a face of the grid, return a copy of the case with a
    larger grid.

    A wall pushes points back, so that points of bodies in contact pass the wall only by a small fraction of a cell. Layers
    of cells are added to contain these points. A face that a condition names is not moved. A second call changes nothing
    more.
    """
    grid = case.grid_or_none
    if grid is None or not case.wall:
        return case
    for axis, name in enumerate("xyz"):
        for end in ("lower", "upper") if not case.thin[axis] and name not in grid.periodic else ():
            while _lacks_room(case, grid, axis, end):
                grid = _extended(grid, axis, end)
    return case if grid is case.grid else case.model_copy(update={"grid_or_none": grid})


def _extended(grid: GridCase, axis: int, end: str) -> GridCase:
    """Return a copy of the grid with one more layer of cells at a face, given by its axis and end ("lower" or "upper")."""
    corners = {"lower": list(grid.lower), "upper": list(grid.extent_upper())}
    corners[end][axis] += grid.cell if end == "upper" else -grid.cell
    return grid.model_copy(update={key: tuple(corner) for key, corner in corners.items()})


def _lacks_room(case: Case, grid: GridCase, axis: int, end: str) -> bool:
    """Return True if the grid needs more cells at a face, given by its axis and end ("lower" or "upper"): if no condition
    names the face, and walls closer than ROOM cells to the face act on a body whose motion is free."""
    parts, face = parts_of(case), f"{'xyz'[axis]}-{end}"
    if any(one.constrains_face(face) or one.opens_face(face) for one in parts.of(Condition)):
        return False
    if any(face in one.where for one in parts.of(Absorbing)):
        return False
    moving = [body for body in case.body if not is_driven(body.name, parts)]
    places = _places_of_face(grid, axis, end)
    touching = ([wall for wall in case.wall if body in wall.touching(moving)] for body in moving)
    return any(_is_close(walls, places, axis, end, grid) for walls in touching)


def _is_close(walls: list[Wall], places: np.ndarray, axis: int, end: str, grid: GridCase) -> bool:
    """Return True if a face of the grid, given by its axis and end ("lower" or "upper"), lies less than ROOM cells in front
    of or behind the walls that face into the grid at this face.

    places: sampled positions on the face [m], shape (n, 3); positions behind other walls are ignored. The distance is
    measured at the position that is farthest in front of the walls or, if all positions are behind the walls, least deep.
    """
    planes = [wall.plane() for wall in walls]
    inward = [plane.normal[axis] * (1.0 if end == "lower" else -1.0) for plane in planes]
    facing = [plane for plane, cosine in zip(planes, inward, strict=True) if cosine >= FACING]
    aside = [plane for plane, cosine in zip(planes, inward, strict=True) if cosine < FACING]
    for plane in aside:
        places = places[plane.height(places) > -TINY * grid.cell]
    if not facing or not len(places):
        return False
    height = np.min([plane.height(places) for plane in facing], axis=0)
    return bool(abs(height.max()) < (ROOM - ROUNDING) * grid.cell)


def _places_of_face(grid: GridCase, axis: int, end: str) -> np.ndarray:
    """Return sampled positions on a face of the grid, given by its axis and end ("lower" or "upper") [m], shape (n, 3)."""
    ends = [
        np.linspace(low, high, 1 if thin else min(n, MOST_PLACES) + 1)
        for low, high, thin, n in zip(grid.lower, grid.extent_upper(), grid.thin(), grid.counts(), strict=True)
    ]
    ends[axis] = ends[axis][:1] if end == "lower" else ends[axis][-1:]
    return np.stack([place.ravel() for place in np.meshgrid(*ends, indexing="ij")], axis=1)
