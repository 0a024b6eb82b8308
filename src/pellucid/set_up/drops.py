"""Warning about drops in another liquid whose surface the grid moves too slowly.

The velocity along the surface of a drop that oscillates in a liquid changes within a thin layer on both sides. Shape functions
as wide as this layer smooth it, so more liquid moves with the surface. `validation/drop-in-liquid` has the error of the period
of a plane drop in a liquid of the same density: 8 to 12 % with 7.5 cells per radius, 1 to 4 % with 15.
"""

from collections.abc import Iterator

import numpy as np

from pellucid.bodies.material_points.model import MaterialPointsCase
from pellucid.case import Case
from pellucid.conditions.symmetry import symmetry_planes
from pellucid.set_up.indenters import box_in_grid, box_with_images

FEWEST = 12.0  # cells per radius: the middle between a period that is 8 to 12 % too long and one that is 1 to 4 % too long
HEAVY = 0.1  # density relative to that of the drop, below which a surrounding fluid hardly takes part in the motion


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
        lower, upper = box_with_images(box_in_grid(drop.bounds(), case.grid), planes, case.grid.cell)
        radius = 0.5 * float((upper - lower)[active].min()) / case.grid.cell
        if beside and radius < FEWEST:
            yield (
                f"body {drop.name} has {radius:.2g} cells in its radius, fewer than {FEWEST:g}. If it oscillates in "
                f"{beside[0]}, it does so too slowly, and damped too much: with 7.5 cells per radius the period is 8 to 12 % "
                'too long, with 15 cells 1 to 4 %, the smaller values with time.transfer = "aflip". Set a smaller grid.cell.'
            )
