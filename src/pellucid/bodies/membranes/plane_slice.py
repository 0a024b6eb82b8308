"""Membranes in plane problems: the surface is a band (strip) along a thin axis, of which a slice with the thickness of the grid
is computed."""

from collections.abc import Iterator

import numpy as np

from pellucid.findings import Finding, Path
from pellucid.geometry.meshes.triangulation import Triangulation, directed_edges
from pellucid.grid.model import GridCase

FLAT = 1e-6  # smallest extent along an axis that counts, relative to the largest extent
LEANING = 1e-3  # relative deviation of a band from its axis that is allowed, since files have single precision


def slice_factor(vertices: np.ndarray, grid: GridCase | None) -> float:
    """Return the factor by which mass and forces of the whole surface with these vertices [m], shape (n, 3), are multiplied
    to get mass and forces of the computed slice.

    For each thin axis (one cell thick) along which the surface extends, the factor is the thickness of the slice divided by
    the extent of the surface. An axis without extent is normal to the membrane, which is included with its full thickness.
    """
    if grid is None:
        return 1.0
    deep = _bands(vertices, grid)
    return float(np.prod(grid.slice_thickness() / np.ptp(vertices, axis=0)[deep]))


def is_loop(vertices: np.ndarray, triangles: np.ndarray, grid: GridCase) -> bool:
    """Return True if a surface that is a band (strip) along a thin axis of the grid encloses an area in the plane, i.e. its
    only rims are normal to this axis. vertices: [m], shape (n, 3); triangles: shape (t, 3).
    """
    bands = _bands(vertices, grid)
    if len(bands) != 1:
        return False
    ends = vertices[_rim(triangles)][:, :, bands[0]]
    return bool((np.abs(ends[:, 1] - ends[:, 0]) <= LEANING * np.ptp(vertices[:, bands[0]])).all())


def slice_problems(path: Path, surface: Triangulation, grid: GridCase) -> Iterator[Finding]:
    """Yield findings (errors of the case) for a surface at `path` that extends beyond the single cell of a thin axis, or is
    not a band (strip) along it.
    """
    vertices, triangles = surface
    for axis in np.flatnonzero(grid.thin()):
        name, low, high = "xyz"[axis], vertices[:, axis].min(), vertices[:, axis].max()
        first, last = grid.lower[axis], grid.extent_upper()[axis]
        if low < first or high > last:
            reach = f"extends from {low:g} to {high:g} m" if high > low else f"is at {low:g} m"
            text = f"{reach} along {name}, beyond the grid's one cell there: {first:g} to {last:g} m"
            yield Finding(path, text, "end it within the cell: a band may be thinner, its depth has no effect")
    a, b, c = vertices[triangles.T]
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    rim = vertices[_rim(triangles)]
    for axis in _bands(vertices, grid):
        name, low, high = "xyz"[axis], vertices[:, axis].min(), vertices[:, axis].max()
        slack = LEANING * (high - low)
        at_ends = np.any(np.abs(rim[:, :, axis, None] - (low, high)).max(axis=1) <= slack, axis=1)
        along = np.linalg.norm(np.delete(rim[:, 1] - rim[:, 0], axis, axis=1), axis=1) <= slack
        if np.abs(normal[:, axis]).max() > LEANING or not np.all(at_ends | along):
            text = (
                f"the surface is neither flat across {name} nor a band along it, but "
                f"the grid is one cell thick along {name}, where"
            )
            remedy = f"extend it from {low:g} to {high:g} m along {name} everywhere, like a rectangle or the faces of a box"
            yield Finding(path, f"{text} nothing varies", f"{remedy}; or enlarge the grid")


def _bands(vertices: np.ndarray, grid: GridCase) -> np.ndarray:
    """Return the numbers of the thin axes of the grid (one cell thick) along which the surface extends as a band."""
    extent = np.ptp(vertices, axis=0)
    return np.flatnonzero(np.array(grid.thin()) & (extent > FLAT * extent.max()))


def _rim(triangles: np.ndarray) -> np.ndarray:
    """Return the edges that belong to only one triangle, as node numbers, shape (k, 2)."""
    edges, count = np.unique(np.sort(directed_edges(triangles), axis=1), axis=0, return_counts=True)
    return np.asarray(edges[count == 1])
