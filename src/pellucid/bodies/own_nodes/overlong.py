"""Warnings of elements and faces that are too long for the cells on which they touch other bodies."""

import numpy as np

from pellucid.grid.lattice import Grid

LONGEST = 1.5
"""Cells: elements are at most one cell long at the start, and from two on, nodes of the grid between theirs have no contact.

Longer faces of solids have more points, but only their corners carry a load.
"""


def nodes_about(grid: Grid, place: np.ndarray) -> np.ndarray:
    """Return the 8 nodes of the grid about places [m], shape (n, 3), as numbers of shape (8, n)."""
    lattice, thin = grid.lattice, grid.thin
    cell = np.floor((place - lattice.lower) * lattice.inverse_cell).astype(np.int64)
    cell = np.where(grid.periodic, cell % np.array(lattice.counts), cell)
    first = np.where(thin, 0, cell) @ np.array(lattice.strides)
    ends = [0 if flat else stride for flat, stride in zip(thin, lattice.strides, strict=True)]
    return np.array([grid.real_nodes(first + int(np.dot(way, ends))) for way in np.ndindex(2, 2, 2)])


def find_overlong(what: str, corners: np.ndarray, place: np.ndarray, grid: Grid, nodes: np.ndarray, effect: str) -> str | None:
    """Return a warning of the longest element near any of these nodes of the grid, shape (n,); None up to `LONGEST` cells.

    what: name of the elements, such as "body sheet touches another, its element"; corners: of these, shape (m, 3 or 4); place:
    of the corners [m], shape (k, 3); effect: consequence and remedy.
    Lengths along an axis that is one cell thick do not count: nothing varies there.
    """
    lattice, thin = grid.lattice, grid.thin
    flat = np.where(thin, 0.0, place)[corners]
    length = np.linalg.norm(flat - np.roll(flat, 1, axis=1), axis=2).max(axis=1)
    near = np.asarray(np.isin(nodes_about(grid, place), nodes).any(axis=0))
    length[~near[corners].any(axis=1)] = 0.0
    worst = int(np.argmax(length))
    if length[worst] <= LONGEST * lattice.cell:
        return None
    centre = ", ".join(f"{value:.4g}" for value in place[corners[worst]].mean(axis=0))
    return (
        f"where {what} {worst} at ({centre}) m is {length[worst]:.3g} m long, {length[worst] / lattice.cell:.2g} cells of "
        f"{lattice.cell:g} m: {effect}"
    )
