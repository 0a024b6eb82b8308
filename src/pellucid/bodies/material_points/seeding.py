"""Filling shapes with material points."""

from collections.abc import Sequence

import numpy as np

from pellucid.bodies.material_points.cutting import shares_of_cells
from pellucid.geometry.shapes.contract import Geometry
from pellucid.geometry.shapes.solids import Box
from pellucid.grid.model import GridCase


def points_along_axes(
    points_per_cell: int | tuple[int, int, int] | None, thin: tuple[bool, bool, bool]
) -> tuple[int, int, int]:
    """Points per cell along x, y, z; a single number is shared equally over the axes that are not thin.

    Raises ValueError where it cannot be.
    """
    if isinstance(points_per_cell, tuple):
        return points_per_cell
    active = 3 - sum(thin)
    each = 2 if points_per_cell is None else round(float(points_per_cell) ** (1.0 / active))
    if points_per_cell is not None and each**active != points_per_cell:
        listed = ", ".join(str(n**active) for n in range(1, 6))
        raise ValueError(
            f"points_per_cell = {points_per_cell} cannot be shared equally by {active} axes; "
            f"use one of {listed}, or list the points along x, y, z"
        )
    x, y, z = (1 if flat else each for flat in thin)
    return x, y, z


def seed(
    shape: Geometry, grid: GridCase, per_cell: tuple[int, int, int], left_out: Sequence[Geometry] = ()
) -> tuple[np.ndarray, np.ndarray]:
    """Positions [m], shape (n, 3), and volumes [m³], shape (n,), of points that fill a shape but for what is left out.

    A box is filled by a lattice of its own, and so is a shape that has one: volumes are equal. Other shapes are filled by the
    points of the grid's lattice that lie inside, each with the part of its lattice cell that belongs to the shape, and in the
    middle of that part; so is a box where something is left out, but there the points stay on the lattice (see
    `pellucid.bodies.material_points.cutting`). Volumes sum to that of the shape exactly.

    Raises ValueError where parts that are left are too thin for the distance between points.
    """
    if shape.n_own_points() is not None and not left_out:
        return shape.own_points()
    thin = np.array(grid.thin())
    x, y, z = (not flat for flat in grid.thin())
    active = (x, y, z)
    centres, spacing = _lattice(shape, grid, per_cell)
    across = grid.slice_thickness() ** int(thin.sum())
    if left_out or not isinstance(shape, Box):
        points, shares = shares_of_cells(shape, left_out, centres, spacing, active)
        return points, shares * across
    points = centres[shape.contains(centres, active)]
    n = max(len(points), 1)
    return points, np.full(len(points), shape.measure(active) * across / n)


def _lattice(shape: Geometry, grid: GridCase, per_cell: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Centres [m], shape (n, 3), of the lattice cells about a shape, and their edges [m], shape (3,)."""
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
        first = np.floor((np.maximum(lower, grid.lower) - grid.lower) / spacing)
        last = np.ceil((np.minimum(upper, grid.extent_upper()) - grid.lower) / spacing)
        axes = [g + (np.arange(a, b) + 0.5) * s for g, a, b, s in zip(grid.lower, first, last, spacing, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3), spacing
