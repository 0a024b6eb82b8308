"""Shape functions between points and nodes: one file each."""

from collections.abc import Callable
from typing import Any

from pellucid.approximants.cubic_bspline import CubicBSpline
from pellucid.approximants.gimp import Gimp
from pellucid.approximants.quadratic_bspline import QuadraticBSpline
from pellucid.approximants.trilinear import Trilinear

# by the name in the case file; each takes the points per cell along each axis
GRID_FUNCTIONS: dict[str, Callable[[tuple[int, int, int]], Any]] = {
    "trilinear": lambda per_cell: Trilinear(),
    "gimp": lambda per_cell: Gimp((0.5 / per_cell[0], 0.5 / per_cell[1], 0.5 / per_cell[2])),
    "quadratic-bspline": lambda per_cell: QuadraticBSpline(),
    "cubic-bspline": lambda per_cell: CubicBSpline(),
}
