"""Description of the grid in a case file."""

from typing import Annotated, Literal

from pydantic import model_validator

from pellucid.approximants import GRID_FUNCTIONS
from pellucid.model import Model, Vector, parameter
from pellucid.registry import OneNameOf

DEFAULT_THICKNESS = 1.0  # m
MOST_CELLS = 1e9  # along an axis; no machine holds more
FEWEST_CELLS = 4  # along a periodic axis: no function reaches a node twice


class GridCase(Model):
    """A uniform Cartesian grid. An axis no longer than one cell is one cell thick: its velocity is constrained to zero.

    A plane problem computes a slice of `thickness`, a one-dimensional problem a bar with a cross-section of thickness by
    thickness. Masses, energies, momenta and forces refer to this slice or bar, for any cell size.
    """

    lower: Vector = parameter("m", "lower corner")
    upper: Vector = parameter("m", "upper corner; an axis of extent 0 is one cell thick")
    cell: float = parameter("m", "edge of the cubic cells", gt=0)
    functions: Annotated[str, OneNameOf(GRID_FUNCTIONS)] = parameter("", "shape functions between points and nodes", "gimp")
    periodic: tuple[Literal["x", "y", "z"], ...] = parameter(
        "", "periodic axes: the upper and lower faces are identical and not walls", ()
    )
    thickness: float | None = parameter(
        "m", f"thickness of the slice along axes that are one cell thick; default: {DEFAULT_THICKNESS:g} m", None, gt=0
    )

    @model_validator(mode="after")
    def _whole_cells(self) -> "GridCase":
        for axis, low, high in zip("xyz", self.lower, self.upper, strict=True):
            if high < low:
                raise ValueError(f"grid.upper along {axis} is {high:g} m, below grid.lower {low:g} m; swap them")
            cells = (high - low) / self.cell
            if cells > MOST_CELLS:
                raise ValueError(f"{cells:.3g} cells of {self.cell:g} m along {axis} are too many; use a larger grid.cell")
            if cells > 1.0 + 1e-6 and abs(cells - round(cells)) > 1e-6 * cells:
                fit = (high - low) / round(cells)
                raise ValueError(
                    f"the grid's extent along {axis} is {high - low:g} m, {cells:.6g} cells of {self.cell:g} m; it must be a "
                    f"whole number of cells: use cell = {fit:.10g} or move grid.upper"
                )
        self._check_periods()
        if all(self.thin()):
            raise ValueError("the grid is at most one cell thick along every axis; make grid.upper larger or cell smaller")
        if self.thickness is not None and not any(self.thin()):
            raise ValueError(
                f"thickness = {self.thickness:g} m applies to axes that are one cell thick, but this grid has none; remove it, "
                f"or make grid.upper equal to grid.lower along an axis"
            )
        return self

    def _check_periods(self) -> None:
        for axis, thin, cells in zip("xyz", self.thin(), self.counts(), strict=True):
            if axis not in self.periodic:
                continue
            if self.periodic.count(axis) > 1:
                raise ValueError(f"periodic lists the axis {axis} twice; remove one")
            if thin:
                raise ValueError(f"periodic lists {axis}, but the grid is one cell thick along {axis}; remove {axis} from it")
            if cells < FEWEST_CELLS:
                raise ValueError(
                    f"the grid is periodic along {axis} with {cells} cells; at least {FEWEST_CELLS} are needed: use a "
                    "smaller grid.cell, or move grid.upper"
                )

    def thin(self) -> tuple[bool, bool, bool]:
        """Return for each axis True if it is one cell thick, so that its velocity is constrained to zero."""
        x, y, z = (high - low <= self.cell * (1.0 + 1e-6) for low, high in zip(self.lower, self.upper, strict=True))
        return x, y, z

    def active_axes(self) -> tuple[bool, bool, bool]:
        """Return for each axis True if the grid is more than one cell thick along it."""
        x, y, z = self.thin()
        return not x, not y, not z

    @property
    def is_smooth(self) -> bool:
        """True if the gradients of the shape functions are continuous, as those of B-splines."""
        return self.functions.endswith("bspline")

    def is_periodic(self) -> tuple[bool, bool, bool]:
        """Return for each axis True if it is periodic."""
        return "x" in self.periodic, "y" in self.periodic, "z" in self.periodic

    def periods(self) -> Vector:
        """Return the period along each axis [m]; 0 along axes that are not periodic."""
        x, y, z = (n * self.cell if folds else 0.0 for n, folds in zip(self.counts(), self.is_periodic(), strict=True))
        return x, y, z

    def seam(self, face: str) -> tuple[str, str] | None:
        """Return why a face such as "x-lower" is no wall, and a remedy, if the axis of the face is periodic; None otherwise."""
        if face[0] not in self.periodic:
            return None
        other = f"{face[0]}-{'upper' if face.endswith('lower') else 'lower'}"
        text = f"the grid is periodic along {face[0]}: the face {face} is not a wall; points that cross it enter at {other}"
        return text, f"name another face, or remove {face[0]} from grid.periodic"

    def slice_thickness(self) -> float:
        """Return the extent of the bodies along each thin axis [m]: the thickness of the slice or bar that is computed."""
        return DEFAULT_THICKNESS if self.thickness is None else self.thickness

    def counts(self) -> tuple[int, int, int]:
        """Return the number of cells along each axis."""
        x, y, z = (
            1 if thin else round((high - low) / self.cell)
            for low, high, thin in zip(self.lower, self.upper, self.thin(), strict=True)
        )
        return x, y, z

    def extent_upper(self) -> tuple[float, float, float]:
        """Return the upper corner of the region that the grid cells fill [m]. Along a thin axis it may exceed `upper`."""
        x, y, z = (low + n * self.cell for low, n in zip(self.lower, self.counts(), strict=True))
        return x, y, z
