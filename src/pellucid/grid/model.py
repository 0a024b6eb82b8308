"""The grid as the user describes it."""

from typing import Annotated

from pydantic import model_validator

from pellucid.approximants import GRID_FUNCTIONS
from pellucid.model import Model, Vector, parameter
from pellucid.registry import OneNameOf

DEFAULT_THICKNESS = 1.0  # m
MOST_CELLS = 1e9  # along an axis; no machine holds more


class GridCase(Model):
    """A uniform Cartesian grid. An axis no longer than one cell is one cell thick: its velocity is constrained to zero.

    Of a plane problem a slice of `thickness` is computed, of a one-dimensional one a bar of thickness by thickness: masses,
    energies, momenta and forces are theirs, whatever the cell.
    """

    lower: Vector = parameter("m", "lower corner")
    upper: Vector = parameter("m", "upper corner; an axis of extent 0 is one cell thick")
    cell: float = parameter("m", "edge of the cubic cells", gt=0)
    functions: Annotated[str, OneNameOf(GRID_FUNCTIONS)] = parameter("", "shape functions between points and nodes", "gimp")
    thickness: float | None = parameter(
        "m", f"extent of the bodies along axes that are one cell thick; {DEFAULT_THICKNESS:g} m where not given", None, gt=0
    )

    @model_validator(mode="after")
    def _whole_cells(self) -> "GridCase":
        for axis, low, high in zip("xyz", self.lower, self.upper, strict=True):
            if high < low:
                raise ValueError(f"grid.upper along {axis} is {high:g} m, below grid.lower {low:g} m; exchange them")
            cells = (high - low) / self.cell
            if cells > MOST_CELLS:
                raise ValueError(f"{cells:.3g} cells of {self.cell:g} m along {axis}; use a larger cell")
            if cells > 1.0 + 1e-6 and abs(cells - round(cells)) > 1e-6 * cells:
                fit = (high - low) / round(cells)
                raise ValueError(
                    f"the grid's extent along {axis} is {high - low:g} m, {cells:.6g} cells of {self.cell:g} m; it must be a "
                    f"whole number of cells: use cell = {fit:.10g} or move grid.upper"
                )
        if all(self.thin()):
            raise ValueError("the grid is at most one cell thick along every axis; make grid.upper larger or cell smaller")
        if self.thickness is not None and not any(self.thin()):
            raise ValueError(
                f"thickness = {self.thickness:g} m is for axes that are one cell thick, and this grid has none; leave it out, "
                f"or make grid.upper equal to grid.lower along an axis"
            )
        return self

    def thin(self) -> tuple[bool, bool, bool]:
        """Which axes are one cell thick and constrained."""
        x, y, z = (high - low <= self.cell * (1.0 + 1e-6) for low, high in zip(self.lower, self.upper, strict=True))
        return x, y, z

    def slice_thickness(self) -> float:
        """Extent of the bodies along each thin axis [m]."""
        return DEFAULT_THICKNESS if self.thickness is None else self.thickness

    def counts(self) -> tuple[int, int, int]:
        """Number of cells along each axis."""
        x, y, z = (
            1 if thin else round((high - low) / self.cell)
            for low, high, thin in zip(self.lower, self.upper, self.thin(), strict=True)
        )
        return x, y, z

    def extent_upper(self) -> tuple[float, float, float]:
        """The upper corner of the cells themselves [m]."""
        x, y, z = (low + n * self.cell for low, n in zip(self.lower, self.counts(), strict=True))
        return x, y, z
