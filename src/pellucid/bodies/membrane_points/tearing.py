"""Membranes of points that tear without damage, because neighbours are so far apart that no grid node is common to them."""

import numpy as np

from pellucid.grid.lattice import Grid

LONGEST = 1.5
"""Longest admissible edge in cells. A strip with edges of half a cell at the start carries its load until the edges are 1.1
cells long, for linear functions and quadratic splines. After that, one edge takes all of the stretch, and the others lose
their tension."""


def torn(name: str, place: np.ndarray, triangles: np.ndarray, failed: np.ndarray, grid: Grid) -> str | None:
    """Return a warning about the longest edge of membrane `name`; None if no edge is longer than `LONGEST` grid cells.

    place: positions of its points [m], shape (n, 3); triangles: shape (m, 3); failed: mask of the points that failed by
    damage, shape (n,), whose edges are not checked. Lengths along an axis that is one cell thick are ignored.
    """
    corners = np.where(np.array(grid.thin), 0.0, place)[triangles]
    length = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    length[failed[triangles].any(axis=1)] = 0.0
    worst, cell = int(np.argmax(length)), grid.lattice.cell
    if length[worst] <= LONGEST * cell:
        return None
    centre = ", ".join(f"{value:.4g}" for value in place[triangles[worst]].mean(axis=0))
    return (
        f"membrane {name} is torn: its triangle at ({centre}) m is {length[worst]:.3g} m long, {length[worst] / cell:.2g} "
        f"cells of {cell:g} m; beyond {LONGEST:g} the grid velocities have gaps between its points, which carry no "
        f'tension and let other bodies through; use a finer surface, or kind = "membrane-elements"'
    )
