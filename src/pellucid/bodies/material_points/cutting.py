"""Distribution of the volume of a region among the material points that fill it, if its boundary intersects cells of their
lattice.

Lattice cells at the boundary are sampled by sub-points, which give the fraction of the cell inside the region. A lattice point
inside the region gets the fraction of its own cell. Slivers of cells whose own point is outside are added to the nearest
points inside (equally near points share them), so that no mass is missing or counted twice. All volumes are then scaled to the
measure of the region: the measure of the shape minus the measures of the excluded shapes. The latter are exact if the shape is
a box that contains the excluded shape, and otherwise estimated from the samples.
"""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from pellucid.geometry.shapes.contract import ActiveAxes, Geometry
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


SAMPLES = 512  # samples per lattice cell: 8 along each of three axes, 23 of two
FEWEST_SAMPLES = 64  # samples per cell if many cells are cut, which then are small
SAMPLES_IN_ALL = 8_000_000  # largest number of samples, so that seeding takes seconds
SAMPLES_AT_ONCE = 200_000  # limits the memory to some 20 MB
REACH = 1.5  # in diagonals of a lattice cell: largest distance of a sliver from the point that receives it
NEIGHBOURS = 8  # largest number of equally near points that share a sliver
AS_NEAR = 1e-6  # relative difference of distances that count as equal
LARGEST_SCALE = 0.02  # largest relative correction of the volumes


class FilledRegion:
    """Computes the positions and volumes of the material points that fill a region: a shape minus excluded regions
    `left_out`. The points lie in the cells of a lattice, `cells`. active: True for axes along which the grid has more than
    one cell."""

    def __init__(self, shape: Geometry, left_out: Sequence[Geometry], cells: SeedLattice, active: ActiveAxes) -> None:
        self._shape, self._left_out, self._cells, self._active = shape, left_out, cells, active
        edges = cells.spacing[np.array(active)]
        self._cell, self._far = float(np.prod(edges)), REACH * float(np.linalg.norm(edges))
        self._taken, self._twice = np.zeros(len(left_out)), 0.0  # volumes of the excluded regions, in samples
        self._is_cut = np.concatenate([self._cut(cells.places(*layers)) for layers in cells.chunks()])  # a byte a cell
        n = round(max(FEWEST_SAMPLES, min(SAMPLES, SAMPLES_IN_ALL // max(int(self._is_cut.sum()), 1))) ** (1.0 / sum(active)))
        inner = (np.arange(n) + 0.5) / n - 0.5
        offsets = np.meshgrid(*(inner if a else [0.0] for a in active), indexing="ij")
        self._offsets = np.stack(offsets, axis=-1).reshape(-1, 3) * cells.spacing

    def points(self) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield the positions of the points inside [m], shape (k, 3), and the volume of each divided by the volume of a
        lattice cell, shape (k,), for some layers of the lattice at a time.

        Points also receive slivers (parts of cells whose own point is outside) from neighbouring layers. The nearest point
        of such a sliver may lie in a layer further away, so the search includes further layers.
        """
        cells, reach = self._cells, int(np.ceil(self._far / self._cells.spacing[0] + 0.5))
        for first, end in cells.chunks():
            low, high = max(first - 2 * reach, 0), min(end + 2 * reach, len(cells.axes[0]))
            centres = cells.places(low, high)
            kept, cut = self._kept(centres), self._is_cut[low * cells.layer : high * cells.layer]
            beside, own = (
                slice((max(first - d, low) - low) * cells.layer, (min(end + d, high) - low) * cells.layer) for d in (reach, 0)
            )
            share, middle = self._shares(centres, kept, np.flatnonzero(cut[beside]) + beside.start, own)
            share, moments = self._with_slivers(centres, kept, share, middle, beside)
            mine = np.flatnonzero(kept[own]) + own.start
            places = centres[mine]
            if not self._left_out:
                middles = moments[mine] / share[mine, None]
                inside = self._shape.contains(middles, self._active)
                places[inside] = middles[inside]
            yield places, share[mine]

    def measure(self, total: float) -> float:
        """Return the length [m], area [m²] or volume [m³] of the region, by its dimension, once `points` has yielded all
        points.

        total: sum of the relative volumes that `points` yielded; without points the region counts as empty. Raises ValueError
        if the points represent clearly less than the region, since thin parts of it contain no points.
        """
        if total == 0.0:
            return 0.0
        exact = self._shape.measure(self._active) + self._twice / len(self._offsets) * self._cell
        for other, samples in zip(self._left_out, self._taken, strict=True):
            known = _in_a_box(other, self._shape, self._active)
            exact -= other.measure(self._active) if known else samples / len(self._offsets) * self._cell
        if self._sticks_out():
            exact = total * self._cell
        if self._left_out and abs(exact - total * self._cell) > LARGEST_SCALE * exact:
            raise ValueError(
                f"the points represent {total * self._cell:.4g} of the remaining {exact:.4g} of the shape: the space "
                "that excluded bodies and shapes of supports leave is partly thinner than the distance between points"
            )
        return exact

    def _kept(self, places: np.ndarray) -> np.ndarray:
        """Return a mask of the positions [m], shape (k, 3), that lie in the region."""
        kept = self._shape.contains(places, self._active)
        for other in self._left_out:
            kept &= ~other.contains(places, self._active)
        return kept

    def _cut(self, centres: np.ndarray) -> np.ndarray:
        """Return a mask of the cells that may lie partly outside the region, from their centres [m], shape (k, 3). A box fills
        its own lattice, so only excluded regions cut its cells.
        """
        active, spacing = np.array(self._active), self._cells.spacing
        if not isinstance(self._shape, Box):
            if self._left_out:
                return np.ones(len(centres), dtype=bool)
            middle = self._shape.contains(centres, self._active)
            corners = np.meshgrid(*([-0.5, 0.5] if a else [0.0] for a in self._active), indexing="ij")
            apart = [
                self._shape.contains(centres + corner * spacing, self._active) != middle
                for corner in np.stack(corners, axis=-1).reshape(-1, 3)
            ]
            return np.asarray(np.any(apart, axis=0))
        cut = np.zeros(len(centres), dtype=bool)
        for other in self._left_out:
            lower, upper = other.bounds()
            meets = (centres + 0.5 * spacing > lower) & (centres - 0.5 * spacing < upper)
            cut |= np.all(meets[:, active], axis=1)
        return cut

    def _shares(self, centres: np.ndarray, kept: np.ndarray, cut: np.ndarray, own: slice) -> tuple[np.ndarray, np.ndarray]:
        """Return the fraction of each lattice cell that lies in the region, shape (k,), and the centroid of this part of the
        cell [m], shape (k, 3). Also count the samples in the cells `own` that each excluded region excludes, and the samples
        excluded twice.

        centres: centres of the cells [m], shape (k, 3); kept: mask of the centres in the region; cut: numbers of the cells that
        are sampled, since they may lie partly outside; own: slice of the cells that are counted.
        """
        share, middle, offsets = kept.astype(float), centres.copy(), self._offsets
        for chunk in np.array_split(cut, 1 + len(cut) * len(offsets) // SAMPLES_AT_ONCE):
            samples = (centres[chunk, None] + offsets).reshape(-1, 3)
            counted = np.repeat((chunk >= own.start) & (chunk < own.stop), len(offsets))
            inside = self._shape.contains(samples, self._active)
            free = inside.copy()
            for k, other in enumerate(self._left_out):
                there = inside & other.contains(samples, self._active)
                self._taken[k] += np.count_nonzero(there & counted)
                self._twice += np.count_nonzero(there & ~free & counted)
                free &= ~there
            free = free.reshape(len(chunk), len(offsets))
            counts = free.sum(axis=1)
            share[chunk] = counts / len(offsets)
            middle[chunk] += np.einsum("cs,sd->cd", free, offsets) / np.maximum(counts, 1)[:, None]  # whatever cells are beside
        return share, middle

    def _with_slivers(
        self, centres: np.ndarray, kept: np.ndarray, share: np.ndarray, middle: np.ndarray, beside: slice
    ) -> tuple[np.ndarray, np.ndarray]:
        """Add slivers (parts of cells whose own point is outside) to the points that receive them. Returns the volume fractions
        of the cells, shape (k,), and these fractions times the centroids of the cells, shape (k, 3).

        centres: centres of the cells [m], shape (k, 3); kept: mask of the centres in the region; share, middle: fraction of
        each cell in the region, shape (k,), and centroid of this part [m], shape (k, 3); beside: slice of the cells whose
        slivers are added.
        """
        moments, slivers = middle * share[:, None], np.flatnonzero(~kept[beside] & (share[beside] > 0.0)) + beside.start
        if len(slivers) and kept.any():
            given, taken_by, parts = _slivers(centres, middle, np.flatnonzero(kept), slivers)
            near = np.linalg.norm(middle[given] - centres[taken_by], axis=1) <= self._far
            given, taken_by, parts = given[near], taken_by[near], parts[near]
            np.add.at(moments, taken_by, parts[:, None] * moments[given])
            np.add.at(share, taken_by, parts * share[given])
        return share, moments

    def _sticks_out(self) -> bool:
        """Return True if the shape extends beyond the lattice that fills it."""
        slack = 1e-6 * self._cells.spacing
        (lower, upper), (low, high) = self._shape.bounds(), self._cells.bounds()
        return bool(np.any(((lower < low - slack) | (upper > high + slack))[np.array(self._active)]))


def _slivers(
    centres: np.ndarray, middle: np.ndarray, kept: np.ndarray, slivers: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Assign slivers (parts of cells whose own lattice point is outside) to the nearest points. Returns the cells of the
    slivers, the cells of the points that receive them, and the fraction of each sliver for each point, shape (pairs,) each.
    Equally near points share a sliver, so that symmetric shapes stay symmetric.

    centres: centres of the cells [m], shape (k, 3); middle: centroids of the parts of the cells that lie in the region [m],
    shape (k, 3); kept: numbers of the cells with a point; slivers: numbers of the cells without.
    """
    from scipy.spatial import cKDTree

    count = min(NEIGHBOURS, len(kept))
    distance, found = cKDTree(centres[kept]).query(middle[slivers], k=range(1, count + 1))
    distances = np.asarray(distance)
    as_near = distances <= distances[:, :1] * (1.0 + AS_NEAR)
    row, column = np.nonzero(as_near)
    return slivers[row], kept[np.asarray(found)[row, column]], 1.0 / as_near.sum(axis=1)[row]


def _in_a_box(other: Geometry, shape: Geometry, active: tuple[bool, bool, bool]) -> bool:
    """Return True if `shape` is a box, rotated or not, that contains the bounds of `other` along the active axes."""
    corners = np.stack(np.meshgrid(*np.transpose(other.bounds()), indexing="ij"), axis=-1).reshape(-1, 3)
    box, corners = shape.in_own_frame(corners)
    if not isinstance(box, Box):
        return False
    low, high = box.bounds()
    slack = 1e-9 * (high - low)
    return bool(np.all(((corners >= low - slack) & (corners <= high + slack))[:, np.array(active)]))
