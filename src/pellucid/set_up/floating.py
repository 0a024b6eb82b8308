"""Warnings about bodies that float in a liquid of the same velocity field and therefore stick to it."""

from collections.abc import Iterator

import numpy as np

from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.bodies.membranes.model import MembraneCase
from pellucid.case import Case
from pellucid.case.sections import parts_of
from pellucid.conditions.enclosed.model import Enclosed
from pellucid.findings import listed
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.parts.condition import Condition

ON_FLOOR = 0.5  # largest distance of a body that rests on a face of the grid from this face, in cells

Floating = SeededBody | MembraneCase
"""Kinds of bodies that can displace a liquid in the same velocity field. Meshless solids always have a field of their own."""


def floating_bodies(case: Case) -> Iterator[str]:
    """Yield a warning for each solid or closed membrane that may float in a liquid of the same velocity field.

    On grid nodes to which both contribute, the liquid moves with the body, also along the sides of the body. A layer of
    liquid one cell thick therefore rises and sinks with the body, and the part of this layer above the level of the liquid
    adds to the weight.
    """
    if case.grid_or_none is None or not any(case.gravity):
        return
    seeded = [body for body in case.body if isinstance(body, SeededBody)]
    for body in case.body:
        if not isinstance(body, Floating) or not _displaces(body):
            continue
        beside = [other for other in seeded if other.field == body.field and other.material.flows]
        inside = [other.name for other in seeded if other.field == body.field and _is_inside(other, body)]
        liquids = [liquid.name for liquid in beside if liquid.name not in inside and _floats(body, liquid, case)]
        if liquids and _is_free(body, case):
            contents = f" and to its contents ({listed(inside)})" if inside else ""
            depth = "half a cell" if isinstance(body, SeededBody) else "a cell"
            yield (
                f"body {body.name} shares the velocity field of {listed(liquids)}: the liquid within one cell "
                f"({case.grid.cell:g} m) sticks to it and is lifted with it, so that it floats up to {depth} too deep. "
                f'Add field = "{_free_field(case, body.name)}" to body {body.name}{contents}, for a separate velocity field. '
                "Contact is then frictionless; add a [[contact]] for friction between the two."
            )


def _displaces(body: Floating) -> bool:
    """Return True if a body displaces liquid, i.e. if it is a solid or a closed membrane."""
    return not body.material.flows if isinstance(body, SeededBody) else body.surface.closed


def _is_inside(other: SeededBody, body: Floating) -> bool:
    """Return True if the bounding box of a body of material points (`other`) lies within the bounding box of a membrane
    (`body`)."""
    if not isinstance(body, MembraneCase):
        return False
    (low, high), (lower, upper) = other.bounds(), body.bounds()
    return bool(np.all(low >= lower) and np.all(high <= upper))


def _floats(body: Floating, liquid: SeededBody, case: Case) -> bool:
    """Return True if a body may float in a liquid: if the body is lighter than the liquid, or extends above the liquid
    without resting on the floor. A membrane that contains the liquid does not float."""
    if isinstance(body, MembraneCase) and body.name not in liquid.outside:  # the liquid fills it
        return False
    if _mean_density(body, case) < liquid.material.density:
        return True
    up = -np.array(case.gravity) / np.linalg.norm(case.gravity)
    return _top(body, up) > _top(liquid, up) and not _stands(body, case)


def _mean_density(body: Floating, case: Case) -> float:
    """Return the mean density [kg/m³] of a solid, or of a membrane together with its contents: mass over the volume that
    the body displaces."""
    if isinstance(body, SeededBody):
        return body.material.density
    volume, (vertices, triangles) = body.occupied().measure((True, True, True)), body.surface.triangulate()
    area = float(np.sum(np.linalg.norm(vector_areas(vertices, triangles), axis=1)))
    mass = body.material.density * body.thickness * area
    for other in case.body:
        if isinstance(other, SeededBody) and _is_inside(other, body):
            mass += other.material.density * other.occupied().measure((True, True, True))
    enclosed = (one for one in parts_of(case).of(Enclosed) if one.body == body.name)
    mass += sum(one.amount().contents(volume).mass for one in enclosed)
    return mass / volume


def _top(body: Floating, up: np.ndarray) -> float:
    """Return the height of the highest corner of the bounding box of a body along the unit vector `up` [m]."""
    lower, upper = body.bounds()
    return float(np.sum(np.where(up > 0.0, upper, lower) * up))


def _stands(body: Floating, case: Case) -> bool:
    """Return True if a body is at the start in contact with a face of the grid below it (in the direction of gravity) whose
    normal velocity a support prescribes."""
    lower, upper = body.bounds()
    slack = ON_FLOOR * case.grid.cell
    for axis, pull in enumerate(case.gravity):
        end, gap = (
            ("lower", lower[axis] - case.grid.lower[axis])
            if pull < 0.0
            else ("upper", case.grid.extent_upper()[axis] - upper[axis])
        )
        held = any(support.face_velocity(f"{'xyz'[axis]}-{end}") is not None for support in case.support)
        if pull != 0.0 and gap < slack and held:
            return True
    return False


def _is_free(body: Floating, case: Case) -> bool:
    """Return True if a body can move along gravity.

    A body is not free if a motion prescribes the body, or a part of the body, along gravity. A deformable body is not free
    either if the bounding box of a support's region intersects the bounding box of the body, whatever directions the
    support constrains.
    """
    parts, along = parts_of(case), {axis for axis in range(3) if case.gravity[axis] != 0.0}
    led = {axis for condition in parts.of(Condition) for axis in condition.prescribed_axes(body.name)}
    if along & led:
        return False
    if body.is_rigid:
        return True
    if any(along & motion.axes() for motion in case.motion if motion.body == body.name):  # of a part
        return False
    lower, upper = body.bounds()
    for support in case.support:
        region = support.region()
        shape = getattr(region, "shape", None)
        if shape is not None:
            low, high = shape.geometry().bounds()
            if bool(np.all((np.array(low) <= upper) & (np.array(high) >= lower))):
                return False
    return True


def _free_field(case: Case, name: str) -> str:
    """Return a name for a new velocity field, derived from the body name, that no body of the case uses."""
    fields = {body.field for body in case.body}
    return next(option for option in (name, f"{name}-field", f"{name}-alone") if option not in fields)
