"""Elements that have grown too long for the cells on which they touch other bodies."""

import numpy as np

from pellucid.grid.lattice import Grid

LONGEST = 1.5
"""Cells: elements start with one at most, and from two on, nodes of the grid between theirs have no contact."""


def overlong(name: str, corners: np.ndarray, place: np.ndarray, grid: Grid, nodes: np.ndarray) -> str | None:
    """A warning about the longest element beside any of these nodes of the grid, shape (n,); None up to `LONGEST` cells.

    corners: nodes of the elements of body `name`, shape (m, 4); place: of its nodes in the order of the mesh [m], shape (k, 3).
    Lengths along an axis that is one cell thick do not count: nothing varies there.
    """
    lattice, thin = grid.lattice, grid.thin
    flat = np.where(thin, 0.0, place)[corners]
    length = np.linalg.norm(flat - np.roll(flat, 1, axis=1), axis=2).max(axis=1)
    touching = np.zeros(grid.n_nodes, bool)
    touching[nodes] = True
    cell = np.floor((place - lattice.lower) * lattice.inverse_cell).astype(np.int64)
    first = np.where(thin, 0, cell) @ np.array(lattice.strides)
    ends = [0 if flat_axis else stride for flat_axis, stride in zip(thin, lattice.strides, strict=True)]
    beside = np.zeros(len(place), bool)
    for way in np.ndindex(2, 2, 2):
        beside |= touching[first + int(np.dot(way, ends))]
    length[~beside[corners].any(axis=1)] = 0.0
    worst = int(np.argmax(length))
    if length[worst] <= LONGEST * lattice.cell:
        return None
    centre = ", ".join(f"{value:.4g}" for value in place[corners[worst]].mean(axis=0))
    return (
        f"where body {name} touches another, its element {worst} at ({centre}) m has grown to {length[worst]:.3g} m, "
        f"{length[worst] / lattice.cell:.2g} cells of {lattice.cell:g} m: between nodes more than two cells apart others pass "
        f"through; make the elements finer, or grid.cell larger"
    )
