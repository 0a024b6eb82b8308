"""Bodies whose motion is prescribed as walls of fluids: which bodies act as such walls, and the regions that they fill."""

from collections.abc import Sequence

import numpy as np

from pellucid.conditions.prescribed_motion import Motion
from pellucid.conditions.support import Support
from pellucid.geometry.shapes.contract import ActiveAxes
from pellucid.grid.model import GridCase
from pellucid.parts.body_model import BodyModel, may_be_wall

SAMPLES = 4000  # positions in the bounds of a body at which its thickness is measured
THIN = 0.1  # quantile of the thickness over the body
LEAST_THICKNESS = 0.75  # cells: fluid would pass through the wall of a thinner body
STEPS_IN_A_CELL = 8  # for lengths in a body


def with_walls(
    bodies: Sequence[BodyModel],
    motions: Sequence[Motion],
    supports: Sequence[Support],
    grid: GridCase | None,
) -> list[BodyModel]:
    """Return the bodies of a case: copies of those that act as walls of fluids, which store this, and copies of fluids that
    leave out these walls and the shapes of supports that stop them along all axes.

    motions, supports: of the case; grid: table of the grid, None without.
    """
    if grid is None:
        return list(bodies)
    active, kept, known = grid.active_axes(), [], {body.name for body in bodies}
    whole = [one for one in supports if one.holds_all(active) or one.slips()]
    walls_of = {body.field: _walls_in([o for o in bodies if o.field == body.field], bodies, motions, grid) for body in bodies}
    marked = [body.as_wall(body.name in walls_of[body.field]) for body in bodies]
    for body in marked:
        of_field = [other for other in marked if other.field == body.field]
        shapes = [one.wall_of_fluids() for one in whole if body.is_fluid and one.acts_as_wall_among(of_field)]
        walls = [shape.geometry() for shape in shapes if shape is not None]
        if body.is_fluid:
            others = [other for other in of_field if other.is_wall and other.name not in body.excluded_bodies()]
            others = [other for other in others if known.issuperset(other.excluded_bodies())]
            walls += [region for other in others if (region := other.with_others(marked).wall_region(grid)) is not None]
        kept.append(body.keep_out_of(walls))
    return kept


def _walls_in(
    together: Sequence[BodyModel], bodies: Sequence[BodyModel], motions: Sequence[Motion], grid: GridCase
) -> set[str]:
    """Return the names of the bodies of one velocity field on whose surface fluids do not slip, see
    `pellucid.conditions.no_slip_walls`: motions prescribe their whole motion, none is thinner than a cell, and the only other
    bodies are viscous fluids. together: bodies of the field; bodies, motions: of the case; grid: table of the grid."""
    fluids = [body for body in together if body.is_fluid and not body.is_rigid and body.shear_viscosity > 0.0]
    rest = [body for body in together if body not in fluids]
    if not fluids or not all(is_led(body, motions, grid.active_axes()) for body in rest):
        return set()
    return set() if any(is_thin(body, bodies, grid) for body in rest) else {body.name for body in rest}


def is_thin(body: BodyModel, bodies: Sequence[BodyModel], grid: GridCase) -> bool:
    """Return True if a tenth of a solid is thinner than LEAST_THICKNESS along an axis. bodies: of the case."""
    x, y, z = active = np.array(grid.active_axes())
    names = {other.name for other in bodies}
    region = body.with_others(bodies).wall_region(grid) if names.issuperset(body.excluded_bodies()) else None
    if region is None:
        return True
    lower, upper = region.bounds()
    place = lower + np.random.default_rng(0).random((SAMPLES, 3)) * (upper - lower)
    place = place[region.contains(place, (x, y, z))]
    if not len(place):
        return True
    thickness = np.full(len(place), np.inf)
    steps = np.arange(1, STEPS_IN_A_CELL + 1) / STEPS_IN_A_CELL
    for axis in np.flatnonzero(active):
        length = np.full(len(place), 1.0 / STEPS_IN_A_CELL)
        for way in (-1.0, 1.0):
            on = np.zeros(3)
            on[axis] = way * grid.cell
            inside = [region.contains(place + step * on, (x, y, z)) for step in steps]
            length += np.cumprod(inside, axis=0).sum(axis=0) / STEPS_IN_A_CELL
        thickness = np.minimum(thickness, length)
    return float(np.quantile(thickness, THIN)) < LEAST_THICKNESS


def is_led(body: BodyModel, motions: Sequence[Motion], active: ActiveAxes) -> bool:
    """Return True if a solid with a region of its own follows motions along all axes that are `active` (the grid is more than
    one cell thick) and, if it is rigid, about all axes about which it can turn. motions: of the case."""
    whole = [motion for motion in motions if motion.body == body.name and motion.part is None]
    along = set[int]().union(*(motion.axes() for motion in whole))
    about = set[int]().union(*(motion.turns_about() for motion in whole))
    turns = {axis for axis in range(3) if all(active[other] for other in range(3) if other != axis)}
    moves = {axis for axis in range(3) if active[axis]}
    return may_be_wall(body) and moves <= along and (not body.is_rigid or turns <= about)
