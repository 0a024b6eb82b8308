"""Shape functions between points and nodes: one file each."""

from collections.abc import Callable

from pellucid.approximants.axis import CurvedFunctions, LinearFunctions
from pellucid.approximants.axis import GridFunction as GridFunction
from pellucid.approximants.axis import GridFunctions as GridFunctions
from pellucid.approximants.cubic_bspline import CubicBSpline
from pellucid.approximants.flat import Flat
from pellucid.approximants.gimp import Gimp
from pellucid.approximants.quadratic_bspline import QuadraticBSpline
from pellucid.approximants.trilinear import Trilinear

# along one axis, by the name in the case file; each takes the points per cell along the axis
GRID_FUNCTIONS: dict[str, Callable[[int], GridFunction]] = {
    "trilinear": lambda per_cell: Trilinear(),
    "gimp": lambda per_cell: Gimp(0.5 / per_cell),
    "quadratic-bspline": lambda per_cell: QuadraticBSpline(),
    "cubic-bspline": lambda per_cell: CubicBSpline(),
}


def grid_functions(name: str, per_cell: tuple[int, int, int], thin: tuple[bool, bool, bool]) -> GridFunctions:
    """The functions along x, y, z, whose product is the shape function; flat along thin axes."""
    x, y, z = (Flat() if flat else GRID_FUNCTIONS[name](n) for n, flat in zip(per_cell, thin, strict=True))
    return LinearFunctions(x, y, z) if max(x.stencil, y.stencil, z.stencil) <= 2 else CurvedFunctions(x, y, z)
