"""The lattice of cells around a shape, each with a candidate for a material point at its centre; processed some layers at a
time.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.solids import Box
from pellucid.grid.model import GridCase

CELLS_AT_ONCE = 100_000  # limits the memory to some 10 MB
FEWEST_LAYERS = 24  # least number of layers processed together, since neighbouring layers are read too


class SeedLattice(NamedTuple):
    """A lattice of cells for seeding a shape, numbered so that z varies fastest; a layer of cells is normal to x."""

    axes: tuple[np.ndarray, np.ndarray, np.ndarray]  # coordinates of the cell centres along each axis [m]
    spacing: np.ndarray  # (3,) edges of a cell [m]

    @classmethod
    def of(cls, shape: Geometry, grid: GridCase, per_cell: tuple[int, int, int]) -> "SeedLattice":
        """Build the lattice of points for seeding a shape in a grid: a box is divided into equal cells; for other shapes the
        cells are parts of the grid cells. per_cell: number of points per grid cell along x, y and z.
        """
        thin = np.array(grid.thin())
        lower, upper = shape.bounds()
        lower = np.where(thin, grid.lower, lower)
        upper = np.where(thin, grid.extent_upper(), upper)
        spacing = grid.cell / np.array(per_cell)
        if isinstance(shape, Box):
            counts = np.maximum(np.rint((upper - lower) / spacing), 1).astype(int)
            spacing = (upper - lower) / counts
            axes = [a + (np.arange(n) + 0.5) * s for a, n, s in zip(lower, counts, spacing, strict=True)]
        else:
            # at the faces where a case lets a shape reach over, it ends
            folds = np.array(grid.is_periodic())  # a shape goes on across a seam
            first = np.floor((np.where(folds, lower, np.maximum(lower, grid.lower)) - grid.lower) / spacing)
            last = np.ceil((np.where(folds, upper, np.minimum(upper, grid.extent_upper())) - grid.lower) / spacing)
            axes = [g + (np.arange(a, b) + 0.5) * s for g, a, b, s in zip(grid.lower, first, last, spacing, strict=True)]
        x, y, z = axes
        return cls((x, y, z), spacing)

    @property
    def layer(self) -> int:
        """Number of lattice cells in a layer, which is normal to x."""
        return len(self.axes[1]) * len(self.axes[2])

    def places(self, first: int, end: int) -> np.ndarray:
        """Return the centres of the lattice cells [m], shape (k, 3), in the layers (normal to x) from `first` to `end`, without
        the layer `end`.
        """
        x, y, z = self.axes
        return np.stack(np.meshgrid(x[first:end], y, z, indexing="ij"), axis=-1).reshape(-1, 3)

    def chunks(self) -> Iterator[tuple[int, int]]:
        """Yield ranges of layers (of lattice cells, normal to x) that are processed together to limit the memory: first layer,
        and the layer after the last.
        """
        step, layers = max(CELLS_AT_ONCE // max(self.layer, 1), FEWEST_LAYERS), len(self.axes[0])
        for first in range(0, max(layers, 1), step):
            yield first, min(first + step, layers)

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lower and the upper corner of the lattice [m]."""
        lower, upper = (np.array([axis[end] for axis in self.axes]) for end in (0, -1))
        return lower - 0.5 * self.spacing, upper + 0.5 * self.spacing
