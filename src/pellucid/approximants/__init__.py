"""Shape functions of points on the grid and of bodies with their own nodes."""

from collections.abc import Callable
from typing import Any

from pellucid.approximants.grid_functions import (
    FAR,
    CubicBSpline,
    CurvedFunctions,
    Flat,
    Gimp,
    LinearFunctions,
    QuadraticBSpline,
    Trilinear,
)
from pellucid.approximants.grid_functions import GridFunction as GridFunction
from pellucid.approximants.grid_functions import GridFunctions as GridFunctions
from pellucid.approximants.grid_functions import MirroredAxis as MirroredAxis
from pellucid.approximants.grid_functions import PeriodicAxis as PeriodicAxis

# functions along one axis, by name in the case; the argument is the number of points per cell along the axis
GRID_FUNCTIONS: dict[str, Callable[[int], GridFunction]] = {
    "trilinear": lambda per_cell: Trilinear(),
    "gimp": lambda per_cell: Gimp(0.5 / per_cell),
    "quadratic-bspline": lambda per_cell: QuadraticBSpline(),
    "cubic-bspline": lambda per_cell: CubicBSpline(),
}


Axes = tuple[bool, bool, bool]
NO_AXES = False, False, False
Ends = tuple[tuple[bool, bool], tuple[bool, bool], tuple[bool, bool]]
"""For each axis a flag of its lower and its upper end."""
NO_ENDS: Ends = ((False, False), (False, False), (False, False))


def grid_functions(
    name: str, per_cell: tuple[int, int, int], thin: Axes, periodic: Axes = NO_AXES, mirrored: Ends = NO_ENDS
) -> GridFunctions:
    """Return the shape functions along x, y, z, whose product is the shape function of a grid node.

    name: kind of shape function in a case, such as "gimp". per_cell: number of material points per cell along each axis. The
    function is constant along `thin` axes (axes of a single cell) and periodic along `periodic` axes. mirrored: ends of axes
    that are planes of symmetry; linear functions do not reach beyond them.
    """
    x, y, z = (_along(name, *kind) for kind in zip(per_cell, thin, periodic, mirrored, strict=True))
    return LinearFunctions(x, y, z) if max(x.stencil, y.stencil, z.stencil) <= 2 else CurvedFunctions(x, y, z)


def _along(name: str, per_cell: int, flat: bool, periodic: bool, mirrored: tuple[bool, bool]) -> GridFunction:
    function = Flat() if flat else GRID_FUNCTIONS[name](per_cell)
    if any(mirrored) and function.stencil > 2:
        return MirroredAxis(function, function.stencil, *(FAR if plane else 0 for plane in mirrored))
    return PeriodicAxis(function, function.stencil) if periodic else function


def image_along(function: Any, node: int, n: int) -> int:
    """Return the node number along an axis of n cells; for a node beyond a plane of symmetry that of its mirror image.

    function: shape function along the axis.
    """
    if isinstance(function, MirroredAxis):
        node = -node if node < 0 and function.lower else node
        node = 2 * n - node if node > n and function.upper else node
    return node


def with_walls(function: Any) -> Any:
    """Return the shape function along an axis with walls instead of planes of symmetry at its ends; function: along an axis of
    any kind."""
    return function.function if isinstance(function, MirroredAxis) else function
