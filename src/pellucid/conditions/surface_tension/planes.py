"""Walls that are planes across the cells of the grid, as the surface energy of a fluid beside them takes them.

The space before the planes is sampled by parts of cells, each with the share of it that lies before them, which is exact for
planes along the axes. From it follow the share of the volume about a node and of a cell that the fluid can fill, and the area
of the planes about a node.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pellucid.approximants import GridFunctions
from pellucid.approximants.axis import axis_weights
from pellucid.contact.wall import WallPlane
from pellucid.grid.lattice import Grid

PARTS, PARTS_IN_SPACE = 8, 4  # of a cell along each axis
MOST_PARTS = 4_000_000  # at a time


class WettedPlane(NamedTuple):
    """A wall at rest, and the cosine of its contact angle."""

    wall: WallPlane
    cosine: float


class OpenSpace(NamedTuple):
    """The space before some planes, by nodes within the faces of the grid, shape (x, y, z), and by cells."""

    nodes: np.ndarray
    """Share of the volume about each node that lies before the planes."""
    cells: np.ndarray
    """Share of each cell."""
    areas: list[np.ndarray]
    """Of each plane, its area about each node [m²]."""


def find_open_space(grid: Grid, functions: GridFunctions, planes: Sequence[WettedPlane]) -> OpenSpace:
    """Sample the space before planes."""
    axes = [_Samples(grid, function, axis) for axis, function in enumerate(functions)]
    shape = tuple(axis.smooth.shape[1] for axis in axes)
    cells = tuple(axis.boxes.shape[1] for axis in axes)
    nodes, share, areas = np.zeros(shape), np.zeros(cells), [np.zeros(shape) for _ in planes]
    part = [axis.width for axis in axes]
    rows = max(1, MOST_PARTS // (len(axes[1].place) * len(axes[2].place)))
    for start in range(0, len(axes[0].place), rows):
        of_x = slice(start, start + rows)
        x, y, z = axes[0].place[of_x, None, None], axes[1].place[None, :, None], axes[2].place[None, None, :]
        before, at = [], []
        for plane in planes:
            normal = plane.wall.normal
            height = normal[0] * x + normal[1] * y + normal[2] * z - plane.wall.level
            across = float(np.abs(normal * [0.0 if thin else p for thin, p in zip(grid.thin, part, strict=True)]).sum())
            before.append(np.clip(0.5 + height / across, 0.0, 1.0))
            at.append(np.maximum(1.0 - np.abs(height) / across, 0.0) * (float(np.prod(part)) / across))
        whole = np.prod(before, axis=0)
        nodes += _collect(whole, [axes[0].smooth[of_x], axes[1].smooth, axes[2].smooth])
        share += _collect(whole, [axes[0].boxes[of_x], axes[1].boxes, axes[2].boxes])
        linear = [axes[0].linear[of_x], axes[1].linear, axes[2].linear]
        for number, (area, density) in enumerate(zip(areas, at, strict=True)):
            others = np.prod([one for other, one in enumerate(before) if other != number], axis=0)
            area += _collect(density * others, linear)
    about = [axis.smooth.sum(axis=0) for axis in axes]
    return OpenSpace(nodes / np.einsum("i,j,k->ijk", *about), share, areas)


class _Samples:
    """Parts of the cells along an axis, and what they give to nodes and cells, shape (parts, nodes) or (parts, cells)."""

    def __init__(self, grid: Grid, function: object, axis: int) -> None:
        count, cell = grid.lattice.counts[axis], grid.lattice.cell
        if grid.thin[axis]:
            self.place, self.width = np.array([grid.lattice.lower[axis]]), grid.slice_thickness
            self.smooth = self.linear = self.boxes = np.ones((1, 1))
            return
        parts = PARTS if any(grid.thin) else PARTS_IN_SPACE
        u = (np.arange(count * parts) + 0.5) / parts
        self.place, self.width = grid.lattice.lower[axis] + cell * u, cell / parts
        smooth, self.linear = np.zeros((len(u), count + 4)), np.zeros((len(u), count + 1))
        self.boxes = np.zeros((len(u), count))
        for row, at in enumerate(u):
            first, weights, _ = axis_weights(function, at, count)
            smooth[row, first : first + len(weights)] += weights
            left = int(at)
            self.linear[row, left : left + 2] = left + 1.0 - at, at - left
            self.boxes[row, left] = 1.0 / parts
        self.smooth = smooth[:, : count + 1]  # weights beyond a face are zero


def _collect(values: np.ndarray, weights: Sequence[np.ndarray]) -> np.ndarray:
    """Sums over parts, shape (x, y, z), by their weights along the axes; einsum adds in one order on any number of threads."""
    x, y, z = weights
    along_z = np.einsum("abc,ck->abk", values, z)
    return np.asarray(np.einsum("ajk,ai->ijk", np.einsum("abk,bj->ajk", along_z, y), x))
