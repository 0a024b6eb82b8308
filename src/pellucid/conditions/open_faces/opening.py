"""Nodes around an opening in a face of the grid, and the layers of nodes that move with the flow through it."""

from typing import NamedTuple

import numpy as np

from pellucid.approximants.grid_functions import GridFunction, GridFunctions, axis_weights
from pellucid.conditions.open_faces.columns import Columns, OpenFace
from pellucid.grid.lattice import Grid

LEAST_WEIGHT = 1e-12  # smallest weight of a node that points reach
SAMPLES = tuple(k / 24 for k in range(25))
"""Sample positions of a point in a cell, as fractions of the cell size. They include the ends of all shape functions,
also of GIMP with 1 to 4 or 6 points per cell."""


class NodesAcross(NamedTuple):
    """Nodes of one layer parallel to a face to which the columns of points behind the opening contribute, with their
    weights. A weight belongs to a pair of column and node."""

    place: np.ndarray  # (m, 3) positions of the nodes if the layer lies on the face [m]
    stored: np.ndarray  # (m,) storage indices of the nodes if the layer lies at the lower end of the grid
    column: np.ndarray  # (e,) index of the column of each pair
    node: np.ndarray  # (e,) index of the node of each pair, from 0 to m - 1
    weight: np.ndarray  # (e,) shape function of the node at the column, within the layer

    def at_columns(self, nodal: np.ndarray, n: int) -> np.ndarray:
        """Interpolate nodal values, shape (m,), to the n columns of points; return shape (n,)."""
        return np.bincount(self.column, self.weight * nodal[self.node], n)


def nodes_across(columns: Columns, grid: Grid, functions: GridFunctions, face: OpenFace) -> NodesAcross:
    """Return the nodes of one layer parallel to a face to which the columns of points behind the face contribute, with their
    weights; functions: shape functions of the grid along each axis."""
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
    """Return the indices along the normal of the layers of nodes to which points in the cells at a face contribute, shape
    (l,); function: shape functions along the normal."""
    reached = {i for depth in SAMPLES for i in _layers_at(depth, grid, function, face)}
    return np.array(sorted(reached), np.int64)


def led_depth(grid: Grid, function: GridFunction, face: OpenFace) -> float:
    """Return the distance from a face up to which points contribute only to the node layers that `layers` returns [m]: 1 to
    2 cells, depending on the shape functions (`function`)."""
    led = set(layers(grid, function, face).tolist())
    deeper = [1.0 + depth for depth in SAMPLES if _layers_at(1.0 + depth, grid, function, face) <= led]
    return max(deeper) * grid.lattice.cell


def _layers_at(depth: float, grid: Grid, function: GridFunction, face: OpenFace) -> set[int]:
    n = grid.lattice.counts[face.axis]
    return {i for i, _ in _weights(function, n - depth if face.is_upper else depth, n)}


def _reached(function: GridFunction, place: float, grid: Grid, axis: int) -> list[tuple[int, float]]:
    """Return the indices of the nodes along an axis to which a point at the coordinate `place` [m] contributes, with their
    weights; function: shape functions along the axis."""
    n, lattice = grid.lattice.counts[axis], grid.lattice
    found = _weights(function, (place - lattice.lower[axis]) * lattice.inverse_cell, n)
    return [(i % n if grid.periodic[axis] else i, w) for i, w in found]


def _weights(function: GridFunction, u: float, n: int) -> list[tuple[int, float]]:
    first, weights, _ = axis_weights(function, u, n)
    return [(int(first) + k, float(w)) for k, w in enumerate(weights) if abs(w) > LEAST_WEIGHT]
