"""Nodes constrained by supports: those of the grid, and those of bodies with their own."""

from collections.abc import Sequence
from typing import Protocol

import numpy as np

from pellucid.errors import CaseError, Problem
from pellucid.grid.lattice import Grid
from pellucid.grid.momentum import Supports
from pellucid.parts.assembly import NO_AXES
from pellucid.parts.body import NodalSupport

REACH = 1e-6  # of a cell, by which a node may lie beyond a box and still count


class ConstrainsNodes(Protocol):
    """A support, as nodes need it."""

    @property
    def velocity(self) -> tuple[float, float, float]: ...
    def box(self) -> tuple[np.ndarray, np.ndarray] | None: ...
    def face(self) -> tuple[int, int] | None: ...
    def axes(self) -> tuple[bool, bool, bool]: ...


def constrain_nodes(grid: Grid, supports: Sequence[ConstrainsNodes]) -> Supports:
    """Mark the constrained directions of nodes. Where supports overlap the later one counts; the last row is of thin axes."""
    index, position = grid.where()
    constrained = grid.nodes.constrained
    for number, support in enumerate(supports):
        inside = nodes_of(support, grid, position)
        if not inside.any():
            raise CaseError(
                Problem(
                    "constrains no node of the grid: the box lies between nodes or beyond the grid",
                    f"support.{number}.where",
                    remedy=f"make the box at least one cell ({grid.lattice.cell:g} m) wide",
                )
            )
        for axis in np.flatnonzero(support.axes()):
            constrained[index[inside], axis] = number + 1
    for axis in np.flatnonzero(grid.thin):
        constrained[:, axis] = len(supports) + 1
    velocity = np.array([*(support.velocity for support in supports), (0.0, 0.0, 0.0)])
    faces = [support.face() is not None for support in supports]
    return Supports(velocity, np.array([*faces, True], dtype=np.int64))


def nodal_support(grid: Grid | None, support: ConstrainsNodes) -> NodalSupport:
    """A support for bodies with their own nodes; a face of the grid that it constrains along its normal is a wall to them."""
    face, axes = support.face(), support.axes()
    wall = face if face is not None and axes[face[0]] else None
    return NodalSupport(lambda position: nodes_of(support, grid, position), axes, support.velocity, wall)


def nodes_of(support: ConstrainsNodes, grid: Grid | None, position: np.ndarray) -> np.ndarray:
    """Which nodes at positions [m], shape (n, 3), a support constrains, shape (n,): those of the grid or a body's own."""
    box = support.box()
    if box is not None:
        lower, upper = box
        reach = REACH * grid.lattice.cell if grid else 0.0
        inside = (position >= lower - reach) & (position <= upper + reach)
        return np.asarray(np.all(inside[:, ~np.array(grid.thin if grid else NO_AXES)], axis=1))
    face = support.face()
    if face is None or grid is None:
        return np.ones(len(position), bool)
    axis, end = face
    if grid.thin[axis]:
        return np.ones(len(position), bool)
    cells = (position[:, axis] - grid.lattice.lower[axis]) / grid.lattice.cell
    return np.asarray(np.abs(cells - end * grid.lattice.counts[axis]) <= REACH)
