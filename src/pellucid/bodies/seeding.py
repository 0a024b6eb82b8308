"""Filling shapes with material points."""

import numpy as np

from pellucid.geometry.shapes import Box, Cylinder, Sphere
from pellucid.grid.spec import GridCase


def points_along_axes(
    points_per_cell: int | tuple[int, int, int] | None, thin: tuple[bool, bool, bool]
) -> tuple[int, int, int]:
    """Points per cell along x, y, z; a single number is shared equally among the axes that are not thin.

    Raises ValueError where it cannot be.
    """
    if isinstance(points_per_cell, tuple):
        return points_per_cell
    active = 3 - sum(thin)
    each = 2 if points_per_cell is None else round(float(points_per_cell) ** (1.0 / active))
    if points_per_cell is not None and each**active != points_per_cell:
        listed = ", ".join(str(n**active) for n in range(1, 6))
        raise ValueError(
            f"points_per_cell = {points_per_cell} cannot be shared equally among {active} axes; "
            f"use one of {listed}, or list the points along x, y, z"
        )
    x, y, z = (1 if flat else each for flat in thin)
    return x, y, z


def seed(shape: Box | Sphere | Cylinder, grid: GridCase, per_cell: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    """Positions [m], shape (n, 3), and volumes [m³], shape (n,), of points that fill a shape.

    A box is filled by a lattice of its own; other shapes by the points of the grid's lattice that lie inside. Volumes sum to
    that of the shape exactly.
    """
    thin = np.array(grid.thin())
    x, y, z = (not flat for flat in grid.thin())
    active = (x, y, z)
    lower, upper = shape.bounds()
    lower = np.where(thin, grid.lower, lower)
    upper = np.where(thin, grid.extent_upper(), upper)
    spacing = grid.cell / np.array(per_cell)
    if isinstance(shape, Box):
        counts = np.maximum(np.rint((upper - lower) / spacing), 1).astype(int)
        axes = [a + (np.arange(n) + 0.5) * (b - a) / n for a, b, n in zip(lower, upper, counts, strict=True)]
    else:
        first = np.floor((lower - grid.lower) / spacing)
        last = np.ceil((upper - grid.lower) / spacing)
        axes = [g + (np.arange(a, b) + 0.5) * s for g, a, b, s in zip(grid.lower, first, last, spacing, strict=True)]
    lattice = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    points = lattice[shape.contains(lattice, active)]
    thickness = grid.cell ** int(thin.sum())
    n = max(len(points), 1)
    return points, np.full(len(points), shape.measure(active) * thickness / n)
