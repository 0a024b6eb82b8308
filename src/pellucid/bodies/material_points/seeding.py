"""Seeding: fills shapes with material points."""

from collections.abc import Callable, Sequence
from math import fsum
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.bodies.material_points.cutting import FilledRegion, SeedLattice
from pellucid.geometry.shapes.contract import Geometry
from pellucid.grid.model import GridCase
from pellucid.reductions import exact_parts

if TYPE_CHECKING:
    pass


def points_along_axes(
    points_per_cell: int | tuple[int, int, int] | None, thin: tuple[bool, bool, bool]
) -> tuple[int, int, int]:
    """Return the number of points per cell along x, y, z.

    points_per_cell: number in a cell, or numbers along the axes; None: two along each axis that is not thin; thin: True for
    axes along which the grid has one cell. A single number is distributed equally over the axes with more than one cell.
    Raises ValueError if an equal distribution is impossible.
    """
    if isinstance(points_per_cell, tuple):
        return points_per_cell
    active = 3 - sum(thin)
    each = 2 if points_per_cell is None else round(float(points_per_cell) ** (1.0 / active))
    if points_per_cell is not None and each**active != points_per_cell:
        listed = ", ".join(str(n**active) for n in range(1, 6))
        raise ValueError(
            f"points_per_cell = {points_per_cell} cannot be distributed equally among {active} axes; "
            f"use one of {listed}, or list the points along x, y, z"
        )
    x, y, z = (1 if flat else each for flat in thin)
    return x, y, z


Wanted = Callable[[np.ndarray], np.ndarray]
"""Function that selects points by their positions [m], shape (k, 3): returns the indices of the selected ones in ascending
order."""


class Seeds(NamedTuple):
    """Numbers, positions and volumes of m selected material points among the n points that fill a region."""

    number: np.ndarray  # (m,) numbers of the selected points among all, ascending
    position: np.ndarray  # (m, 3) [m]
    volume: np.ndarray  # (m,) [m³]
    n: int  # number of all points


def everywhere(position: np.ndarray) -> np.ndarray:
    """Return the indices of all positions, shape (n,): a selection function that selects every point."""
    return np.arange(len(position))


def seed(
    shape: Geometry,
    grid: GridCase,
    per_cell: tuple[int, int, int],
    left_out: Sequence[Geometry] = (),
    wanted: Wanted = everywhere,
) -> Seeds:
    """Fill a shape, minus the excluded regions, with material points, and return the points that `wanted` selects.

    per_cell: number of points per grid cell along x, y and z; left_out: excluded regions; wanted: function that returns the
    indices of the selected positions. A box, and any other shape that provides its own lattice, is filled by that lattice with
    equal volumes. Other shapes are filled by the points of the grid's lattice that lie inside: each has the volume of the part
    of its lattice cell inside the shape, and lies at the centroid of this part. A box with excluded regions is filled in the
    same way, but its points stay on the lattice (see `pellucid.bodies.material_points.cutting`). The sum of the volumes is
    exactly the volume of the shape. Points that are not selected are dropped, some layers of the lattice at a time. Raises
    ValueError if remaining parts are too thin for the spacing of the points.
    """
    if shape.n_own_points() is not None and not left_out:
        position, volume = shape.own_points()
        number = wanted(position)
        return Seeds(number, position[number], volume[number], len(position))
    active = grid.active_axes()
    cells = SeedLattice.of(shape, grid, per_cell)
    region = FilledRegion(shape, left_out, cells, active)
    n, total, found = 0, list[float](), list[tuple[np.ndarray, ...]]()
    for position, share in region.points():
        chosen = wanted(position)
        found.append((n + chosen, position[chosen], share[chosen]))
        total += exact_parts(share)
        n += len(position)
    number, position, share = (np.concatenate(parts) for parts in zip(*found, strict=True))
    shares = fsum(total)
    whole = region.measure(shares) * grid.slice_thickness() ** sum(grid.thin()) / (shares or 1.0)
    return Seeds(number, position, share * whole, n)
