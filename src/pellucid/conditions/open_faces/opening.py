"""The opening in a face of the grid: the columns of points that come in through it, and the nodes about them.

A lattice of points stands in the layer of cells at the face as a body's own does at the start. Each place of its outermost
layer begins a column along the normal, in which points follow each other at the spacing of the lattice.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from pellucid.approximants.axis import GridFunction, GridFunctions, axis_weights
from pellucid.bodies.material_points.seed_lattice import SeedLattice
from pellucid.bodies.material_points.seeding import points_along_axes, seed
from pellucid.geometry.shape import Shape
from pellucid.geometry.shapes.contract import Geometry
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase

LEAST_WEIGHT = 1e-12  # of a node that points reach
SAMPLES = (0.0, 0.25, 0.5, 0.75, 1.0)  # of a cell, where its functions do not vanish


class OpenFace(NamedTuple):
    """A face of the grid."""

    name: str
    axis: int
    is_upper: bool
    level: float  # [m]

    @classmethod
    def of(cls, face: str, grid: GridCase) -> "OpenFace":
        """By its name, such as "x-lower"."""
        axis, upper = "xyz".index(face[0]), face.endswith("upper")
        return cls(face, axis, upper, float((grid.extent_upper() if upper else grid.lower)[axis]))

    @property
    def inward(self) -> float:
        """1 or -1, the direction into the grid along its axis."""
        return -1.0 if self.is_upper else 1.0

    def depth(self, position: np.ndarray) -> np.ndarray:
        """How far positions [m], shape (n, 3), are within the grid [m], shape (n,)."""
        return self.inward * (position[:, self.axis] - self.level)


class Columns(NamedTuple):
    """Columns of points behind an opening."""

    place: np.ndarray  # (c, 3) of their first points [m]
    depth: np.ndarray  # (c,) how far these are from the face [m]
    area: np.ndarray  # (c,) across the flow [m²]
    spacing: float  # of points in a column [m]

    @property
    def n(self) -> int:
        """Their number."""
        return len(self.area)


def columns(
    shape: Geometry, left_out: Sequence[Geometry], per_cell: int | tuple[int, int, int] | None, grid: GridCase, face: OpenFace
) -> Columns:
    """Those where a shape, less what is left out, meets a face; none where it does not."""
    counts = points_along_axes(per_cell, grid.thin())
    spacing = float(SeedLattice.of(shape, grid, counts).spacing[face.axis])

    def outermost(position: np.ndarray) -> np.ndarray:
        depth = face.depth(position)
        return np.flatnonzero((depth >= 0.0) & (depth < spacing * (1.0 - 1e-9)))

    seeds = seed(shape, grid, counts, left_out, outermost)
    return Columns(seeds.position, face.depth(seeds.position), seeds.volume / spacing, spacing)


def opening_of(through: Shape | None, face: OpenFace, model: Any, grid: GridCase) -> tuple[Columns, Geometry]:
    """The columns of an opening and its shape: a given one, or where a body meets the face, by its model."""
    shape = (through or model.shape).geometry()
    return columns(shape, () if through else model.left_out, model.points_per_cell, grid, face), shape


class NodesAcross(NamedTuple):
    """The nodes of a layer that columns reach, and with what weights."""

    place: np.ndarray  # (m, 3) [m]; along the normal at the face
    stored: np.ndarray  # (m,) where they are stored, those of the layer at the lower end of the grid
    column: np.ndarray  # (e,) of each weight the column
    node: np.ndarray  # (e,) and the node, of the m
    weight: np.ndarray  # (e,)

    def at_columns(self, nodal: np.ndarray, n: int) -> np.ndarray:
        """What nodes have, shape (m,), at the n columns."""
        return np.bincount(self.column, self.weight * nodal[self.node], n)


def nodes_across(columns: Columns, grid: Grid, functions: GridFunctions, face: OpenFace) -> NodesAcross:
    """Those of the columns behind a face."""
    lattice, across = grid.lattice, [axis for axis in range(3) if axis != face.axis]
    numbers: dict[tuple[int, ...], int] = {}
    column, node, weight = list[int](), list[int](), list[float]()
    for c, place in enumerate(columns.place.tolist()):
        one, other = (_reached(functions[axis], place[axis], grid, axis) for axis in across)
        for i, v in one:
            for j, w in other:
                column.append(c)
                node.append(numbers.setdefault((i, j), len(numbers)))
                weight.append(v * w)
    index = np.array(list(numbers), np.int64).reshape(-1, 2)
    place = np.tile(np.array(lattice.lower), (len(index), 1))
    place[:, across] += index * lattice.cell
    place[:, face.axis] = face.level
    stored = index @ np.array([lattice.strides[axis] for axis in across])
    return NodesAcross(place, stored, np.array(column, np.int64), np.array(node, np.int64), np.array(weight))


def layers(grid: Grid, function: GridFunction, face: OpenFace) -> np.ndarray:
    """The layers of nodes that points in the layer of cells at a face reach, (l,)."""
    n = grid.lattice.counts[face.axis]
    cell = n - 1 if face.is_upper else 0
    reached = {i for sample in SAMPLES for i, _ in _weights(function, cell + sample, n)}
    return np.array(sorted(reached), np.int64)


def _reached(function: GridFunction, place: float, grid: Grid, axis: int) -> list[tuple[int, float]]:
    """The nodes along an axis that a place [m] reaches, with their weights."""
    n, lattice = grid.lattice.counts[axis], grid.lattice
    found = _weights(function, (place - lattice.lower[axis]) * lattice.inverse_cell, n)
    return [(i % n if grid.periodic[axis] else i, w) for i, w in found]


def _weights(function: GridFunction, u: float, n: int) -> list[tuple[int, float]]:
    first, weights, _ = axis_weights(function, u, n)
    return [(int(first) + k, float(w)) for k, w in enumerate(weights) if abs(w) > LEAST_WEIGHT]
