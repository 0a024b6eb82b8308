"""Positions of bodies of a periodic grid for pictures: bodies that have left the box of the grid through a periodic face are
moved back into it."""

from collections.abc import Callable, Mapping

import numpy as np

from pellucid.geometry.meshes.cells import Cells
from pellucid.grid.model import GridCase

SEAM = "seam"
"""Name of the additional field with the displacement of points into the periodic box [m], shape (n, 3)."""


def in_box(fields: dict[str, np.ndarray], cells: Callable[[], Cells], grid: GridCase | None) -> dict[str, np.ndarray]:
    """Return the fields of a body after moving its positions into the box of the periodic grid; unchanged if the grid is
    not periodic.

    Points without cells are moved one by one; a body with a mesh is moved as a whole, according to the centre of its
    points. The displacement is added as the field `seam` [m]. cells: function that returns the cells of the body.
    """
    if grid is None or not grid.periodic:
        return fields
    moved = way_into_box(fields["position"], cells(), grid)
    return {**fields, "position": fields["position"] + moved, SEAM: moved}


def way_into_box(position: np.ndarray, cells: Cells, grid: GridCase | None) -> np.ndarray:
    """Return the displacement that moves points into the box of a periodic grid [m], shape (n, 3): multiples of its periods.

    position: [m], shape (n, 3). cells: cells of the body; a body with cells is moved as a whole.
    """
    way = np.zeros_like(position)
    for axis, period in enumerate(grid.periods() if grid is not None else ()):
        if period == 0.0:
            continue
        x = position[:, axis]
        if any(len(corners) for corners in (cells.lines, cells.triangles, cells.quadrilaterals, cells.tetrahedra)):
            x = np.full(len(x), np.mean(x[np.isfinite(x)]) if np.isfinite(x).any() else 0.0)
        way[:, axis] = -period * np.floor((x - grid.lower[axis]) / period) if grid is not None else 0.0
    return way


def places_unmoved(fields: Mapping[str, np.ndarray]) -> np.ndarray:
    """Return the positions of the points before `in_box` moved them into the periodic box [m], shape (n, 3). Displacements are
    computed from these."""
    return fields["position"] - fields.get(SEAM, 0.0)
