"""Shape functions of points on the grid and of bodies with their own nodes."""

from collections.abc import Callable

from pellucid.approximants.grid_functions import (
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


def grid_functions(name: str, per_cell: tuple[int, int, int], thin: Axes, periodic: Axes = NO_AXES) -> GridFunctions:
    """Return the shape functions along x, y, z, whose product is the shape function of a grid node.

    name: kind of shape function in a case, such as "gimp". per_cell: number of material points per cell along each axis. The
    function is constant along `thin` axes (axes of a single cell) and periodic along `periodic` axes.
    """
    x, y, z = (_along(name, n, *kind) for n, *kind in zip(per_cell, thin, periodic, strict=True))
    return LinearFunctions(x, y, z) if max(x.stencil, y.stencil, z.stencil) <= 2 else CurvedFunctions(x, y, z)


def _along(name: str, per_cell: int, flat: bool, periodic: bool) -> GridFunction:
    function = Flat() if flat else GRID_FUNCTIONS[name](per_cell)
    return PeriodicAxis(function, function.stencil) if periodic else function
