"""Opening in a face of the grid: the columns of points that enter through it.

A lattice of points fills the layer of cells at the face, like the initial lattice of a body. Each position of its outermost
layer starts a column along the normal. Points in a column follow each other at the spacing of the lattice.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pellucid.bodies.material_points.cutting import SeedLattice
from pellucid.bodies.material_points.seeding import points_along_axes, seed
from pellucid.findings import Reason
from pellucid.geometry.region import Shape
from pellucid.geometry.shapes.contract import Geometry
from pellucid.grid.model import GridCase

ROUNDING = 1e-6  # of a cell


class OpenFace(NamedTuple):
    """A face of the grid through which points enter or leave."""

    name: str  # such as "x-lower"
    axis: int  # index of the normal axis, 0 to 2
    is_upper: bool  # True if the face is at the upper end of the grid along the axis
    level: float  # position of the face along its axis [m]

    @classmethod
    def of(cls, face: str, grid: GridCase) -> "OpenFace":
        """Build a face from its name, such as "x-lower"."""
        axis, upper = "xyz".index(face[0]), face.endswith("upper")
        return cls(face, axis, upper, float((grid.extent_upper() if upper else grid.lower)[axis]))

    @property
    def inward(self) -> float:
        """Direction into the grid along the axis of the face, 1 or -1."""
        return -1.0 if self.is_upper else 1.0

    def nodes(self, grid: GridCase) -> np.ndarray:
        """Return the positions of the nodes of the face [m], shape (n, 3)."""
        axes = [np.linspace(*ends) for ends in zip(grid.lower, grid.extent_upper(), np.array(grid.counts()) + 1, strict=True)]
        axes[self.axis] = axes[self.axis][[-1 if self.is_upper else 0]]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)

    def depth(self, position: np.ndarray) -> np.ndarray:
        """Return the distances from the face into the grid [m], shape (n,), of positions [m], shape (n, 3); negative
        outside."""
        return self.inward * (position[:, self.axis] - self.level)


class Columns(NamedTuple):
    """Columns of points (lines along the normal of a face of the grid, in which points enter one after another) behind an
    opening in the face; c: number of columns."""

    place: np.ndarray  # (c, 3) positions of the first points of the columns [m]
    depth: np.ndarray  # (c,) distances of the first points from the face [m]
    area: np.ndarray  # (c,) cross-sectional area of each column [m²]
    spacing: float  # spacing of points in a column [m]

    @property
    def n(self) -> int:
        """Number of columns of points that enter through the opening."""
        return len(self.area)


def _endless(grid: GridCase) -> np.ndarray:
    """Return a mask of the axes along which shapes do not end at faces of the grid: periodic axes, and axes along which the
    grid is one cell thick; shape (3,)."""
    return np.array(grid.thin()) | np.array(grid.is_periodic())


def why_apart(name: str, shape: Geometry, face: OpenFace, grid: GridCase) -> Reason | None:
    """Return the reason why the bounding box of a shape does not intersect a face within the grid, None if it does; name:
    name of the shape in the message."""
    rounding, ends = ROUNDING * grid.cell, zip(grid.lower, grid.extent_upper(), _endless(grid), strict=True)
    for axis, (low, high, (start, end, endless)) in enumerate(zip(*shape.bounds(), ends, strict=True)):
        if axis == face.axis and not low - rounding <= face.level <= high + rounding:
            text = (
                f"{name} lies between {low:g} and {high:g} m along {'xyz'[axis]}, but the face {face.name} at {face.level:g} m"
            )
            return Reason(text, "extend it through the face, one cell deep into the grid")
        if axis != face.axis and not endless and (high <= start or low >= end):
            text = f"{name} lies between {low:g} and {high:g} m along {'xyz'[axis]}, but the face {face.name}"
            return Reason(f"{text} between {start:g} and {end:g} m", "extend or move it to the face")
    return None


def columns(
    shape: Geometry, left_out: Sequence[Geometry], per_cell: int | tuple[int, int, int] | None, grid: GridCase, face: OpenFace
) -> Columns:
    """Return the columns of points where a shape, without the shapes in `left_out`, intersects a face within the grid;
    per_cell: points per cell, in total or along each axis (None: default)."""
    counts = points_along_axes(per_cell, grid.thin())
    lower, upper, endless = np.array(grid.lower), np.array(grid.extent_upper()), _endless(grid)
    spacing = float(SeedLattice.of(shape, grid, counts).spacing[face.axis])

    def outermost(position: np.ndarray) -> np.ndarray:
        depth = face.depth(position)
        within = (((position >= lower) & (position <= upper)) | endless).all(axis=1)
        return np.flatnonzero(within & (depth >= 0.0) & (depth < spacing * (1.0 - 1e-9)))

    seeds = seed(shape, grid, counts, left_out, outermost)
    return Columns(seeds.position, face.depth(seeds.position), seeds.volume / spacing, spacing)


def opening_of(through: Shape | None, face: OpenFace, model: Any, grid: GridCase) -> tuple[Columns, Geometry]:
    """Return the columns of points of an opening in a face, and the shape of the opening: `through` if given, else the shape
    of the body. model: model of the body of material points."""
    shape = (through or model.shape).geometry()
    return columns(shape, () if through else model.left_out(grid), model.points_per_cell, grid, face), shape
