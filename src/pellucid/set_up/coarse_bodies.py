"""Warnings about bodies whose radius has too few cells or elements: hard bodies (bodies that do not deform) that press on a
soft one with too large a force or pass between its nodes, and drops in another liquid whose surface moves too slowly.

The velocity along the surface of a drop that oscillates in a liquid changes within a thin layer on both sides. Shape functions
as wide as this layer smooth it, so more liquid moves with the surface. `validation/drop-in-liquid` has the error of the period
of a plane drop in a liquid of the same density: 4 to 7 % with 7.5 cells per radius, 0 to 4 % with 15.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from pellucid.bodies.material_points.model import MaterialPointsCase
from pellucid.bodies.membrane_elements.model import MembraneElementsCase
from pellucid.case import Case
from pellucid.conditions.symmetry import symmetry_planes
from pellucid.contact.images import Plane
from pellucid.contact.sheets import PASSES, describe_passage
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.grid.model import GridCase
from pellucid.set_up.gaps import hard_bodies

FEWEST = 3.0  # cells or edges of the soft body in the radius of a hard one, below which its force is far too large
FEWEST_OF_A_DROP = 12.0  # cells per radius: between a period that is 4 to 7 % too long and one that is 0 to 4 % too long
HEAVY = 0.1  # density relative to that of a drop, below which a fluid around it hardly takes part in its motion
Box = tuple[np.ndarray, np.ndarray]
"""Lower and upper corner of a box [m]."""
Faces = tuple[np.ndarray, np.ndarray, np.ndarray]
"""Centres, vector areas and edge lengths of the faces of a body, see `BodyModel.faces_pressed`."""


def coarse_indenters(case: Case) -> Iterator[str]:
    """Yield a warning for each pair of a hard body and a solid of another velocity field whose mesh or points are too coarse
    for the shape of the hard body."""
    planes = symmetry_planes(case.support, case.grid)
    hard = hard_bodies(case)
    names = {body.name for body in hard}
    soft = [body for body in case.body if body.name not in names]
    for one in hard:
        for other in soft:
            if one.field == other.field:
                continue
            faces = other.faces_pressed()
            if other.is_surface or (faces is None and not other.deforms_in_contact):
                continue
            box = _with_images(_within(one.bounds(), case.grid), planes, case.grid.cell)
            radius, spacing = _radius_and_spacing(box, _within(other.bounds(), case.grid), faces, case.grid)
            if radius < FEWEST * spacing:
                resolved_by, finer = (
                    ("cells", "a smaller grid.cell")
                    if faces is None
                    else ("mesh edges", f"a finer mesh of body {other.name} near this place")
                )
                yield (
                    f"the non-deforming body {one.name} has a radius of {radius:.3g} m where it can touch body "
                    f"{other.name}; this is "
                    f"{radius / spacing:.2g} {resolved_by} of {spacing:.3g} m, fewer than {FEWEST:g}. The force of "
                    "indentation of "
                    f"{other.name} is then wrong, mostly too large (by 10 to 70 % at a ratio of 2 or less). Use {finer}."
                )


def coarse_sheets(case: Case) -> Iterator[str]:
    """Yield a warning for each pair of a body and a membrane of another velocity field, if the body can pass between the
    nodes of the membrane."""
    planes = symmetry_planes(case.support, case.grid)
    bodies = [body.with_others(case.body) for body in case.body if not (body.is_fluid or body.is_surface)]
    for sheet in case.body:
        if not isinstance(sheet, MembraneElementsCase):
            continue
        faces = _faces_of_sheet(sheet, case.grid)
        for body in bodies:
            if body.field == sheet.field or not (body.deforms_in_contact or body.is_rigid):
                continue
            box = _with_images(_within(body.bounds(), case.grid), planes, case.grid.cell)
            radius, edge = _radius_and_spacing(box, _within(sheet.bounds(), case.grid), faces, case.grid)
            half = radius + sheet.contact_reach
            if half < PASSES * edge:
                yield describe_passage(body.name, sheet.name, 2.0 * half, "across its way", edge)


def coarse_drops(case: Case) -> Iterator[str]:
    """Yield a warning for each body with surface tension that has too few cells in its radius, half of its smallest extent,
    and shares its velocity field with another fluid of similar density."""
    fluids = {body.name: (body, body.material) for body in case.body if isinstance(body, MaterialPointsCase) and body.is_fluid}
    if not case.surface_tension:  # as in every case without a grid
        return
    planes, active = symmetry_planes(case.support, case.grid), ~np.array(case.thin)
    for condition in case.surface_tension:
        drop, liquid = fluids[condition.body]
        beside = [
            body.name
            for body, other in fluids.values()
            if body is not drop and body.field == drop.field and other.density > HEAVY * liquid.density
        ]
        lower, upper = _with_images(_within(drop.bounds(), case.grid), planes, case.grid.cell)
        radius = 0.5 * float((upper - lower)[active].min()) / case.grid.cell
        if beside and radius < FEWEST_OF_A_DROP:
            yield (
                f"body {drop.name} has {radius:.2g} cells in its radius, fewer than {FEWEST_OF_A_DROP:g}. If it oscillates in "
                f"{beside[0]}, it does so too slowly, and damped too much: with 7.5 cells per radius the period is 2 to 8 % "
                'too long, with 15 cells up to 4 %, the smaller values with time.transfer = "aflip" and time.mass_matrix = '
                '"consistent". Set these keys, and a smaller grid.cell.'
            )


def _faces_of_sheet(sheet: MembraneElementsCase, grid: GridCase) -> Faces:
    """Return the centres [m], vector areas [m²] and edge lengths [m] of the triangles of a membrane (`sheet`), each triangle
    once for either side.

    For a square cut into two triangles, the edge length is the side of the square.
    """
    vertices, triangles = sheet.surface.triangulate()
    corners = np.where(grid.thin(), 0.0, vertices)[triangles]
    edges = np.median(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2), axis=1)
    middle, area = vertices[triangles].mean(axis=1), vector_areas(vertices, triangles)
    return np.concatenate([middle, middle]), np.concatenate([area, -area]), np.concatenate([edges, edges])


def _radius_and_spacing(hard: Box, soft: Box, faces: Faces | None, grid: GridCase) -> tuple[float, float]:
    """Return two lengths [m]: the smallest half extent of a hard body across the direction to a soft body, and the mesh
    length of the soft body where it faces the hard body. hard, soft: bounding boxes; faces: loaded faces of the soft body,
    None for material points.

    If the bodies are separate along several axes, the axis with the largest half extent is used, because the bodies may
    approach along any axis.
    """
    (lower, upper), (low, high), active = hard, soft, ~np.array(grid.thin())
    apart = np.where(active, np.maximum(low - upper, lower - high), -np.inf)
    beside = np.flatnonzero(apart > min(-1e-6 * grid.cell, apart.max() - 1e-12))
    return max(_along(int(axis), hard, soft, faces, grid) for axis in beside)


def _along(axis: int, hard: Box, soft: Box, faces: Faces | None, grid: GridCase) -> tuple[float, float]:
    (lower, upper), (low, high), active = hard, soft, ~np.array(grid.thin())
    across = active & (np.arange(3) != axis)
    covers = upper - lower >= high - low  # a plate on all of the other body has no edge that presses into it
    radius = 0.5 * float((upper - lower)[across & ~covers].min(initial=np.inf))
    if radius == np.inf or faces is None:
        return radius, grid.cell
    place, area, edge = faces
    beside = ((place >= lower - radius) & (place <= upper + radius))[:, across].all(axis=1)
    side = 1.0 if lower[axis] + upper[axis] > low[axis] + high[axis] else -1.0
    beside &= side * area[:, axis] > 0.5 * np.linalg.norm(area, axis=1)
    return radius, float(np.median(edge[beside] if beside.any() else edge))


def _within(box: Box, grid: GridCase) -> Box:
    """Return the part of a box inside the grid."""
    return np.maximum(box[0], grid.lower), np.minimum(box[1], grid.extent_upper())


def _with_images(box: Box, planes: Sequence[Plane], near: float) -> Box:
    """Return a box that encloses a given box and its mirror images at the planes of symmetry that are not further away
    than `near` [m]."""
    lower, upper = box[0].copy(), box[1].copy()
    for axis, place in planes:
        if lower[axis] - near <= place <= upper[axis] + near:
            ends = lower[axis], upper[axis], 2.0 * place - lower[axis], 2.0 * place - upper[axis]
            lower[axis], upper[axis] = min(ends), max(ends)
    return lower, upper
