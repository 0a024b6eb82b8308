"""Warnings about gaps between bodies that do not deform, if they are too narrow to resolve flow or deformation in them.

From points on the boundaries of hard bodies, a ray follows the normal until it reaches another boundary. A flow with
velocities that are linear in each of n cells between two walls at rest, and exact at the nodes, has 1 - 1/n² of the flow
rate of a viscous flow.
"""

from collections.abc import Callable, Iterator
from collections.abc import Set as AbstractSet
from itertools import product
from typing import NamedTuple

import numpy as np

from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.conditions.symmetry import symmetry_planes
from pellucid.contact.approaching_parts import (
    ASIDE,
    NARROW,
    PARALLEL,
    describe_gap,
    find_near,
    find_slit,
    select_facing,
)
from pellucid.contact.wall_plane import WallPlane
from pellucid.geometry.shapes.boundary_points import boundary_points
from pellucid.grid.model import GridCase
from pellucid.parts.body_model import BodyModel
from pellucid.parts.condition import is_driven

FEWEST = 3.0  # cells, in which a viscous flow lacks a ninth
STEP = 0.25  # of a cell: where a boundary is nearer than that along the normal, two touch
BISECTIONS = 6
OPPOSITE = 0.9  # cosine between the normals of the two sides of a gap, at least: it does not taper

Covers = Callable[[np.ndarray], np.ndarray]
"""Function of positions [m], shape (n, 3), that returns a mask of the positions behind a boundary, shape (n,)."""


class Border(NamedTuple):
    """Boundary that material cannot penetrate: a body that does not deform, a wall, or a face of the grid."""

    name: str  # name in messages
    covers: Covers  # function that tests which positions lie behind the boundary
    moves: str
    """Text that identifies the motion: two boundaries with the same text keep their distance."""
    normal: np.ndarray | None = None
    """Unit normal of a plane, towards the bodies; None for a body."""
    is_mirror: bool = False
    """True for a plane of symmetry, behind which the gap continues as its image."""


def narrow_gaps(case: Case, going_on: AbstractSet[str] = frozenset()) -> Iterator[str]:
    """Yield a warning for each pair of boundaries with a gap of fewer than FEWEST cells between them.

    Boundaries are hard bodies (bodies that do not deform), walls, and faces of the grid with a fixed normal velocity.
    There is a warning only if another body starts in the gap, or if the boundaries keep their distance, so that another
    body may enter it. going_on: names of the bodies that continue from an earlier run; they are left out because their
    positions differ from the case.
    """
    grid = case.grid
    hard = [body for body in hard_bodies(case) if not body.is_surface]
    names = {body.name for body in hard} | going_on
    hard = [body for body in hard if body.name not in going_on]
    soft = [body.with_others(case.body) for body in case.body if body.name not in names and not body.is_surface]
    if not hard or not soft:
        return
    active = grid.active_axes()
    borders = [_border(body, case, active) for body in hard]
    points = [_boundary(body, grid) for body in hard]
    others = [*borders, *_planes(case)]
    for i, j in product(range(len(borders)), range(len(others))):
        if j < i:
            continue
        one, other = borders[i], others[j]
        theirs = points[j] if j < len(borders) else None
        place, normal, width = _across(*points[i], one, other, theirs, grid.cell)
        if not len(place):
            continue
        middle = place + 0.5 * width[:, None] * normal
        held = one.moves == other.moves
        for body in soft:
            inside = body.contains(middle, active, grid.periods())
            if not (inside.any() or held):
                continue
            here = inside if inside.any() else np.ones(len(middle), bool)
            cells = float(np.median(width[here])) / grid.cell
            at = ", ".join(f"{value:.4g}" for value in middle[here][0])
            parts = f"parts of {one.name}" if i == j else f"{one.name} and {other.name}"
            content = f"is filled by body {body.name}" if inside.any() else f"may be entered by body {body.name}"
            yield (
                f"the gap between {parts} is {cells:.2g} cells of {grid.cell:g} m wide, fewer than {FEWEST:g}, and "
                f"{content}, for "
                f"example at ({at}) m: shear and flow in it are not resolved (the rate of a viscous flow through n "
                "cells is too "
                f"small by a fraction of 1/n²). Set a smaller grid.cell."
            )
            break


def _border(body: BodyModel, case: Case, active: tuple[bool, bool, bool]) -> Border:
    motions = [motion for motion in case.motion if motion.body == body.name]
    given = [motion.model_dump(exclude={"name", "body", "hold", "hold_rotation"}, exclude_defaults=True) for motion in motions]
    moves = repr([way for way in given if way]) if motions else body.name
    return Border(f"body {body.name}", lambda places: body.contains(places, active, case.grid.periods()), moves)


def _planes(case: Case) -> Iterator[Border]:
    """Yield the boundaries of walls and of faces of the grid with a fixed normal velocity."""
    rest = repr([])
    for number, wall in enumerate(case.wall):
        plane = wall.plane()
        moves = repr(tuple(wall.velocity)) if any(wall.velocity) else rest
        yield Border(wall.name or f"wall {number + 1}", _behind(plane), moves, plane.normal)
    for axis, place in symmetry_planes(case.support, case.grid):
        is_lower = place < 0.5 * (case.grid.lower[axis] + case.grid.extent_upper()[axis])
        face = f"{'xyz'[axis]}-{'lower' if is_lower else 'upper'}"
        along = np.eye(3)[axis]
        (a, b, c), (x, y, z) = (1.0 if is_lower else -1.0) * along, place * along
        at_face = [support for support in case.support if support.constrains_face(face)]
        rubs = any(support.holds_all() or support.wall_friction() > 0.0 for support in at_face)
        plane = WallPlane((x, y, z), (a, b, c), (0.0, 0.0, 0.0))
        yield Border(f"face {face}", _behind(plane), rest, plane.normal, not rubs)


def _behind(plane: WallPlane) -> Covers:
    return lambda places: plane.height(places) < 0.0


def _boundary(body: BodyModel, grid: GridCase) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions [m] of points on the boundary of a body within the grid, about a cell apart, and the outward
    unit normals there, shape (n, 3) each."""
    active = grid.active_axes()
    lower, upper = body.bounds()
    place, area = boundary_points(
        lambda places: body.contains(places, active, grid.periods()),
        lower,
        upper,
        grid.cell,
        active,
        grid.slice_thickness(),
    )
    flat = np.array(grid.thin()) | np.array(grid.is_periodic())
    within = (((place >= grid.lower) & (place <= grid.extent_upper())) | flat).all(axis=1)
    return place[within], area[within] / np.linalg.norm(area[within], axis=1, keepdims=True)


def _across(
    place: np.ndarray, normal: np.ndarray, one: Border, other: Border, theirs: tuple[np.ndarray, np.ndarray] | None, cell: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points of one boundary that face another across a gap of fewer than FEWEST cells.

    The result contains positions [m] and normals, shape (n, 3) each, and gap widths [m], shape (n,). place, normal:
    points and normals of the first boundary `one`; theirs: points and normals of the boundary `other`; None for a plane;
    cell: cell size [m].
    """
    none = place[:0], normal[:0], np.zeros(0)
    reach = FEWEST * (0.5 if other.is_mirror else 1.0) * cell
    met = np.full(len(place), np.inf)
    for width in np.arange(STEP * cell, reach, STEP * cell):
        free = np.isinf(met)
        at = place[free] + width * normal[free]
        met[np.flatnonzero(free)[other.covers(at)]] = width
    if one is not other and (met <= STEP * cell).any():
        return none  # they touch: near the contact the gap tapers
    here = np.isfinite(met) & (met > STEP * cell)
    place, normal, far = place[here], normal[here], met[here]
    near = far - STEP * cell
    for _ in range(BISECTIONS):
        middle = 0.5 * (near + far)
        covered = other.covers(place + middle[:, None] * normal)
        near, far = np.where(covered, near, middle), np.where(covered, middle, far)
    if other.normal is not None:
        facing = np.broadcast_to(other.normal, normal.shape)
    elif theirs is not None and len(place) and len(theirs[0]):
        from scipy.spatial import cKDTree

        facing = theirs[1][cKDTree(theirs[0]).query(place + far[:, None] * normal)[1]]
    else:
        return none
    opposite = np.einsum("ij,ij->i", facing, normal) < -OPPOSITE
    width = far * (2.0 if other.is_mirror else 1.0)
    return place[opposite], normal[opposite], width[opposite]


def hard_bodies(case: Case) -> list[BodyModel]:
    """Return the bodies that are rigid or whose motion is fully prescribed, each as a model with access to the other
    bodies of the case."""
    parts = parts_of(case)
    return [body.with_others(case.body) for body in case.body if body.is_rigid or is_driven(body.name, parts)]


def narrow_slits(case: Case, going_on: AbstractSet[str] = frozenset()) -> Iterator[str]:
    """Yield a warning for each deforming body of material points with a slit so narrow that both of its sides contribute to
    the same nodes.

    going_on: names of the bodies that continue from an earlier run; they are not checked.

    """
    grid = case.grid
    hard = {body.name for body in hard_bodies(case)}
    active = grid.active_axes()
    for model in case.body:
        if not isinstance(model, SeededBody) or model.material.flows or model.name in hard | going_on:
            continue
        if model.shape.geometry().is_convex and not model.outside and not any(grid.is_periodic()):
            continue
        place, area = model.with_others(case.body).boundary(grid, hard=False)
        normal, periods = area / np.linalg.norm(area, axis=1, keepdims=True), np.array(grid.periods())
        one, other = find_near(place, float(np.hypot(NARROW, ASIDE)) * grid.cell, np.array(grid.lower, float), periods)
        facing, _ = select_facing(place, normal, one, other, grid.cell, periods, PARALLEL)
        filled = np.zeros(len(facing.middle), bool)
        for body in case.body:
            if body is not model and not body.is_surface and len(filled):
                filled |= body.with_others(case.body).contains(facing.middle, active, grid.periods())
        slit = find_slit(facing, ~filled, grid.cell)
        if slit is not None:
            yield describe_gap(model.name, slit, grid.cell, at_start=True)
