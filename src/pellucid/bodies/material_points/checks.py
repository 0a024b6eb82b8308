"""Checks of the settings of a body of material points: grid, planes of symmetry, other bodies."""

from collections.abc import Iterator

import numpy as np

from pellucid.bodies.material_points.hydrostatic import FAR, REMEDY, NoRest, far_level, states_by_height
from pellucid.bodies.material_points.seeded_body import SeededBody
from pellucid.bodies.material_points.seeding import points_along_axes
from pellucid.bodies.membranes.model import CLOSE_IT, NEEDS_SPACE
from pellucid.findings import Finding, Path, hint, listed
from pellucid.geometry.checks.surface_checks import faults
from pellucid.geometry.shapes.solids import Box
from pellucid.geometry.surfaces.surface import Inside
from pellucid.grid.model import GridCase
from pellucid.grid.velocity_transfer import AFFINE
from pellucid.model import Vector
from pellucid.parts.body_model import BodyModel, may_be_wall
from pellucid.parts.condition import Condition, is_driven
from pellucid.parts.part import Parts

SHORT = 1e-9  # tolerance for round-off, relative to a cell
NEAR_END = 1e-4  # smallest distance of points from the ends of a body, relative to its extent


def grid_problems(body: SeededBody, path: Path, grid: GridCase) -> Iterator[Finding]:
    """Yield findings (errors of the case) for numbers of points per cell, and shapes of the body, that are impossible on the
    grid.

    path: path of the body in the data of the case.
    """
    try:
        points_along_axes(body.points_per_cell, grid.thin())
    except ValueError as error:
        yield Finding((*path, "points_per_cell"), str(error))
    shape, geometry = (*path, "shape"), body.shape.chosen()
    ends = zip("xyz", *geometry.bounds(), grid.thin(), strict=True)
    for axis, low, high, thin in ends if body.shape.rotate is not None else ():
        if not thin and high <= low:
            text = (
                f"along {axis} the shape extends from {low:g} to {high:g} m before "
                "rotation, so it has no extent along this axis"
            )
            yield Finding(shape, text, "set the upper end above the lower one")
    if any(grid.thin()) and (geometry.n_own_points() is not None or isinstance(geometry, Inside)):
        what = "a lattice of its own" if geometry.n_own_points() is not None else "the inside of a surface"
        yield Finding(shape, f"{what} {NEEDS_SPACE}", "enlarge the grid")
    if isinstance(geometry, Inside):
        if not geometry.surface.closed:
            yield Finding(shape, "the surface is open: it has no inside", CLOSE_IT)
        for text, remedy in faults(*geometry.surface.triangulate(), geometry.surface.closed):
            yield Finding(shape, text, remedy)
    if geometry.n_own_points() is not None and body.outside:
        text = "a shape with its own lattice is filled completely: other bodies cannot be excluded from it"
        yield Finding((*path, "outside"), text, "remove `points` of the shape, or `outside`")
    if body.cut_at and isinstance(body.shape.geometry(), Box):
        text = "a box has its own lattice, which a face does not cut"
        yield Finding((*path, "cut_at"), text, "end the box at the face")
    elif body.cut_at and geometry.n_own_points() is not None:
        text = "a shape with its own lattice is filled completely"
        yield Finding((*path, "cut_at"), text, "remove `points` of the shape, or `cut_at`")


def cut_problems(body: SeededBody, path: Path, grid: GridCase, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for faces of the grid in `cut_at` that the body does not reach, or that are neither
    planes of symmetry nor open to a fluid. path: path of the body in the data of the case; parts: all parts of the case.
    """
    if not parts.are_sound(Condition):
        return
    bounds, walls = body.bounds(), (grid.lower, grid.extent_upper())
    for item, face in enumerate(body.cut_at):
        if reason := grid.seam(face):
            yield Finding((*path, "cut_at", item), *reason)
            continue
        axis, end = "xyz".index(face[0]), int(face.endswith("upper"))
        short = (bounds[end][axis] - walls[end][axis]) * (1.0 if end else -1.0)
        if short < -SHORT * grid.cell:
            text = f"the shape ends {-short:.4g} m before the face {face}, so the face does not cut it"
            yield Finding((*path, "cut_at", item), text, "remove this face, or move the shape or the grid")
            continue
        if body.material.flows and any(condition.opens_face(face) for condition in parts.of(Condition)):
            continue  # the fluid continues beyond an open face
        held = [(place, v) for place, condition in parts.placed(Condition) if (v := condition.face_velocity(face)) is not None]
        here = (*path, "cut_at", item)
        if held and any(held[-1][1]):
            where = ".".join(map(str, held[-1][0]))
            text = f"`{where}` moves the face {face}, but a plane of symmetry must be at rest"
            yield Finding(here, text, f'remove `velocity` from `{where}`, or remove "{face}" from `cut_at`')
        elif not held:
            text = f"no support at rest constrains the face {face} along its normal, so it is not a plane of symmetry"
            remedy = f'if it is one, add a [[support]] with where = "{face}" and fix = "normal"'
            if body.material.flows:
                text += ", and no [[inflow]] or [[outflow]] opens it"
                remedy += "; if the fluid continues beyond the face, add an [[inflow]] or [[outflow]] at this face"
            yield Finding(here, text, remedy)


def rigid_problems(body: SeededBody, path: Path) -> Iterator[Finding]:
    """Yield a finding (an error of the case) if a rigid body has a material that flows. path: path of the body in the data of
    the case.
    """
    if body.is_rigid and body.material.flows:
        text = f'a material of kind "{body.material.kind}" flows, but a rigid body keeps its shape'
        remedy = 'use a solid material of the same density, such as kind = "neo-hookean", or remove `rigid = true`'
        yield Finding((*path, "rigid"), text, remedy)


def hydrostatic_problems(body: SeededBody, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for a hydrostatic initial state of a material that does not flow, without gravity,
    or with no state at rest. path: path of the body in the data of the case; parts: all parts of the case.
    """
    rest, gravity = body.hydrostatic, parts.gravity
    if rest is None or gravity is None:
        return
    here, n_axes = (*path, "hydrostatic"), np.count_nonzero(gravity)
    if not body.material.flows:
        text = f'a material of kind "{body.material.kind}" is not a fluid, so it cannot be in hydrostatic equilibrium'
        yield Finding(here, text, "remove `hydrostatic`")
    elif body.is_rigid:
        yield Finding(here, "a rigid body has no pressure, so it cannot be in hydrostatic equilibrium", "remove `hydrostatic`")
    elif parts.grid is not None and any(
        g != 0.0 and axis in parts.grid.periodic for axis, g in zip("xyz", gravity, strict=True)
    ):
        text = "the grid is periodic along gravity: nothing supports the fluid, and its pressure would jump at the seam"
        yield Finding(here, text, "remove `hydrostatic`, or use walls along the axis of gravity")
    elif n_axes == 0:
        yield Finding(here, "the case has no gravity", "add `gravity`, such as [0, -9.81, 0] m/s^2, or remove `hydrostatic`")
    elif n_axes > 1 and rest.level is None:
        text = "gravity is not along an axis, so the top of the shape's bounds is not a free surface"
        yield Finding((*here, "level"), text, "set the level, a height from the origin against gravity")
    elif rest.level is not None and parts.grid is not None and (found := _far_level(body, path, parts.grid, gravity)):
        yield found
    elif n_axes == 1 and not body.cut_at:  # the points of others may lie well within the bounds: told when these are filled
        lower, upper = body.bounds()
        ends = np.array((lower, upper)) + NEAR_END * np.array((upper - lower, lower - upper))
        try:
            states_by_height(rest, body.material, (lower, upper), gravity, ends)
        except NoRest as error:
            yield Finding(here, str(error), REMEDY)


def _far_level(body: SeededBody, path: Path, grid: GridCase, gravity: Vector) -> Finding | None:
    """Return a finding (an error of the case) if the level at which a fluid has its reference density is so far from the grid
    that the hydrostatic density in the body differs clearly from it; None otherwise. path: path of the body in the data of the
    case; gravity: [m/s²].
    """
    rest = body.hydrostatic
    if rest is None or rest.level is None:
        return None
    walls = np.array(grid.lower), np.array(grid.extent_upper())
    remedy = "set density and pressure to the values at the top of the body, and remove the level"
    found = far_level(rest.level, body.material, body.bounds(), walls, gravity)
    if found is None:
        return None
    bottom, top, ratio = found
    text = (
        f"lies far outside the grid, which covers the heights {bottom:.6g} to {top:.6g} m: in the body the fluid would have "
        f"{ratio:.3g} times its `density`; between 1/{FAR:g} and {FAR:g} times is allowed"
    )
    return Finding((*path, "hydrostatic", "level"), text, remedy)


def cell_pressure_problems(body: SeededBody, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for `cell_pressure` with a material that has shear stress or a second viscosity, or
    with a prescribed motion. path: path of the body in the data of the case; parts: all parts of the case.
    """
    if not body.cell_pressure:
        return
    here, remedy = (*path, "cell_pressure"), "remove cell_pressure; it is for fluids that move freely"
    if not body.material.flows:
        text = f"a material of kind {body.material.kind!r} has shear stresses, so `cell_pressure` cannot be used"
        yield Finding(here, text, remedy)
    elif (found := body.material.implicit_stress()) is not None and found.resists_volume:
        text = "the implicit second viscosity is not compatible with cell pressures"
        yield Finding(here, text, "remove cell_pressure, or material.second_viscosity")
    elif body.is_rigid or is_driven(body.name, parts):
        yield Finding(here, "the body is rigid or follows a prescribed motion: its pressure has no effect", remedy)


def stress_problems(body: SeededBody, path: Path) -> Iterator[Finding]:
    """Yield a finding (an error of the case) for an initial stress of a rigid body or of a material that cannot carry one.

    path: path of the body in the data of the case.
    """
    here = (*path, "initial_stress")
    if body.initial_stress is None:
        return
    if body.is_rigid:
        yield Finding(here, "a rigid body has no stress, so an initial stress has no effect", "remove it")
        return
    try:
        body.material.stressed(body.initial_stress)
    except ValueError as error:
        remedy = "for a fluid, set a pressure or `hydrostatic`; stress other bodies by loads, with [settle]"
        yield Finding(here, str(error), remedy)


def implicit_pressure_problems(body: SeededBody, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for an implicit pressure with unsuitable shape functions, or with bodies that act on
    the liquid after its pressure is solved for. path: path of the body in the data of the case; parts: all parts of the case.
    """
    stress, grid = body.implicit_stress, parts.grid
    if stress is None or stress.stiffness == 0.0 or grid is None:
        return
    here = (*path, "material", "implicit_pressure")
    if not grid.is_smooth:
        text = f"{grid.functions} shape functions let eddies of single cells grow in the long steps of implicit pressure"
        yield Finding(here, text, 'use grid.functions = "quadratic-bspline", or remove implicit_pressure')
    after = [other for other in parts.of(BodyModel) if meets_after_solve(other, body)]
    if after:
        names = listed([other.name for other in after])
        text = f"the pressure is solved for before the contact with {names}, which long steps do not resolve"
        near = (other for other in after if other.field == body.field and may_be_wall(other))
        can_lead = [other.name for other in near if not is_driven(other.name, parts)]
        rest = [other.name for other in after if other.name not in can_lead]
        ways = [f"prescribe the whole motion of {listed(can_lead)} by [[motion]], as of a wall"] if can_lead else []
        ways += [f"place {listed(rest)} in the velocity field of {body.name}, not rigid"] if rest else []
        yield Finding(here, text, f"remove implicit_pressure, or {' and '.join(ways)}")


def meets_after_solve(body: BodyModel, fluid: BodyModel) -> bool:
    """Return True if a body acts on a fluid by contact, after the implicit stress of the fluid is solved for: moving bodies of
    other velocity fields, and rigid ones unless they are walls of the fluid."""
    if body is fluid or not body.moves or (body.is_wall and body.field == fluid.field):
        return False
    return body.is_rigid or body.field != fluid.field


def even_points_problems(body: SeededBody, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for `even_points` without affine velocity fields, and beside membranes.
    path: path of the body in the data of the case; parts: all parts of the case.
    """
    if not body.material.keeps_points_even:
        return
    here, time = (*path, "material", "even_points"), next(iter(parts.sections["time"].items), None)
    if (transfer := getattr(time, "transfer", "apic")) not in AFFINE:
        text = f'points that move need an affine velocity field, which the transfer "{transfer}" does not have'
        yield Finding(here, text, 'use time.transfer = "apic" or "aflip", or remove even_points')
    if membranes := [other.name for other in parts.of(BodyModel) if other.is_surface and other.field == body.field]:
        text = f"it moves points to where points are missing, also through {listed(membranes)} in the same velocity field"
        yield Finding(here, text, "remove even_points")


def outside_problems(body: SeededBody, path: Path, parts: Parts) -> Iterator[Finding]:
    """Yield findings (errors of the case) for names under `outside` that are unknown or repeated, name the body itself, or
    name bodies that cannot be excluded. path: path of the body in the data of the case; parts: all parts of the case.
    """
    names, bodies = parts.names(BodyModel), parts.of(BodyModel)
    for item, name in enumerate(body.outside):
        here = (*path, "outside", item)
        other = parts.named(BodyModel, name)
        if name == body.name:
            yield Finding(here, "a body cannot exclude itself", "remove this name")
        elif name in body.outside[:item]:
            yield Finding(here, "this body is named twice", "remove one of the two names")
        elif name not in names:
            if parts.are_named(BodyModel):
                others = [known for known in names if known != body.name]
                yield Finding(here, f"no body has this name; the others are {listed(others) or 'none'}", hint(name, others))
        elif other is not None and (reason := other.why_not_excluded(parts.grid)):
            yield Finding(here, *reason)
        elif other is not None and body.name in other.excluded_bodies() and bodies.index(other) < bodies.index(body):
            text = f"{name} also excludes {body.name}: their overlap would be empty"
            yield Finding(here, text, "remove one of the two")
