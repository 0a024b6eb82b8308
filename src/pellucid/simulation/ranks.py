"""Simulations on several processes: distribution of points among processes, and load balance.

The grid is divided into slabs, i.e. layers of cells, see `pellucid.grid.points.Slabs`. Each process computes the points in
some of the rows of slabs.
"""

import signal
import time
from collections.abc import Sequence

import numpy as np

from pellucid.bodies.own_nodes.body import ExplicitNodes
from pellucid.bodies.own_nodes.grid_transfer import GridCoupling
from pellucid.errors import CaseError, Interrupted, Problem
from pellucid.grid.lattice import Grid
from pellucid.grid.model import GridCase
from pellucid.grid.point_storage import PointStorage
from pellucid.grid.sorting import rows_of
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.body import Body
from pellucid.parts.body_model import BodyModel
from pellucid.parts.families import GridBody
from pellucid.ranks.domain import domain

INTERVAL = 50
"""Number of steps between two checks of the load balance."""
THINNEST = 1e-9
"""Smallest extent of a body along the axis on which slabs follow each other, in cells, for the estimate of its points per
row."""


def idle(processes: int, fields: Sequence[VelocityField]) -> str | None:
    """Return a warning if some of the given number of processes would have nothing to compute, or None; fields: the velocity
    fields of the case."""
    if processes == 1:
        return None
    if not fields:
        return f"the case has no grid, so each of {processes} processes does all the work. Run it with one process."
    rows = len(fields[0].grid.rows) - 1
    if processes > rows:
        idle = processes - rows
        return f"the grid has only {rows} rows of slabs, so {idle} of {processes} processes are idle. Start at most {rows}."
    return None


def interrupted(signals: Sequence[int]) -> Interrupted:
    """Return the exception that all processes raise after any of them received signals such as SIGTERM and a checkpoint was
    written."""
    error = Interrupted(by_keyboard=signals[0] == signal.SIGINT)
    domain.group.know(error)
    return error


def cut_rows(bodies: Sequence[BodyModel], case: GridCase, grid: Grid) -> None:
    """Distribute rows of slabs (ranges of grid layers) among processes before bodies are built, by estimated numbers of points.
    The estimate assumes that the points of a body fill its bounding box evenly."""
    if domain.group.size == 1:
        return
    if case.is_periodic()[grid.lattice.slab_axis]:
        text = "a grid that is periodic along all axes cannot be shared by several processes"
        raise CaseError(Problem(text, "grid.periodic", remedy="Run it with one process and several threads."))
    functions = grid.functions((1, 1, 1))
    rows, axis = rows_of(grid, functions), grid.lattice.slab_axis
    edges = case.lower[axis] + case.cell * rows.edges
    edges[[0, -1]] = -np.inf, np.inf  # bodies may reach beyond
    below = np.zeros(len(edges))
    for body in bodies:
        low, high = (end[axis] for end in body.bounds())
        share = np.clip((edges - low) / max(high - low, THINNEST * case.cell), 0.0, 1.0)
        below += body.with_others(bodies).n_points(case) * share
    domain.cut(rows, np.diff(below))


class SharedSlabs:
    """Distribution of the points of a simulation: each process computes the points in its own rows of slabs (blocks of grid
    cells)."""

    def __init__(self, bodies: Sequence[Body]) -> None:
        coupled = (body.coupling for body in bodies if isinstance(body, ExplicitNodes))
        on_grid = [body.storage for body in bodies if isinstance(body, GridBody)]
        self._points: list[PointStorage | GridCoupling] = [*on_grid, *(one for one in coupled if one is not None)]
        self._cut_again(domain.group.total(self._count()))

    def _count(self) -> np.ndarray:
        """Return the number of points in each row of slabs (blocks of grid cells) of this process, shape (rows,)."""
        return domain.by_row(np.sum([np.diff(points.slabs.first) for points in self._points], axis=0))

    def balance(self) -> None:
        """Redistribute the rows of slabs (blocks of grid cells) at intervals if some processes compute longer than others.
        Called before a step.

        The cost of a row is its part of the computing time of its process, in proportion to its points. The distribution
        does not change results, bit for bit.
        """
        self._left -= 1
        if self._left > 0:
            return
        worked = time.perf_counter() - self._began - (domain.group.waited - self._waited)
        count = self._count()
        self._cut_again(domain.group.total(count * (worked / max(count.sum(), 1.0))))

    def _cut_again(self, cost: np.ndarray) -> None:
        """Redistribute the rows of slabs (blocks of grid cells) by their computing times `cost` [s], shape (rows,), if that
        saves time."""
        hand_over = [points.hand_over() for points in self._points] if domain.would_pay(cost) else []
        if hand_over:
            domain.cut_again(cost)
        for take_up in hand_over:
            take_up()
        self._left, self._began, self._waited = INTERVAL, time.perf_counter(), domain.group.waited
