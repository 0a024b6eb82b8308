"""A simulation that several processes share: how they share out its points, and how they stay in balance."""

import signal
import time
from collections.abc import Sequence

import numpy as np

from pellucid.bodies.own_nodes.body import ExplicitNodes
from pellucid.bodies.own_nodes.grid_transfer import GridCoupling
from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.errors import Interrupted
from pellucid.grid.lattice import Grid
from pellucid.grid.velocity_field import VelocityField
from pellucid.parts.body import Body
from pellucid.ranks.domain import Rows, domain

INTERVAL = 50
"""Steps between two looks at the balance."""


def idle(processes: int, fields: Sequence[VelocityField]) -> str | None:
    """A warning where some of the processes have nothing to share."""
    if processes == 1:
        return None
    if not fields:
        return f"the case has no grid: each of {processes} processes does all of it; run it on one"
    rows = len(fields[0].grid.rows) - 1
    if processes > rows:
        idle = processes - rows
        return f"the grid has {rows} rows of slabs, and {idle} of {processes} processes have none: start {rows} at most"
    return None


def interrupted(signals: Sequence[int]) -> Interrupted:
    """What all processes raise when any of them caught a signal and a checkpoint is written."""
    error = Interrupted(by_keyboard=signals[0] == signal.SIGINT)
    domain.group.know(error)
    return error


class SharedSlabs:
    """The points of a simulation, of which each process does those in its own rows of slabs."""

    def __init__(self, bodies: Sequence[Body], grid: Grid) -> None:
        coupled = (body.coupling for body in bodies if isinstance(body, ExplicitNodes))
        on_grid = [body for body in bodies if isinstance(body, PointsOnGrid)]
        self._points: list[PointsOnGrid | GridCoupling] = [*on_grid, *(one for one in coupled if one is not None)]
        slabs, lattice = self._points[0].slabs, grid.lattice
        edges = np.append(slabs.layers[:: slabs.across, 0], slabs.layers[-1, 1])
        stencil = max(function.stencil for function in self._points[0].functions)
        self._rows = Rows(edges, slabs.across, stencil, lattice.strides[lattice.slab_axis], grid.n_nodes)
        domain.cut(self._rows, self._count())
        for points in self._points:
            points.share_out()
        self._begin_interval()

    def _count(self) -> np.ndarray:
        """The points in each row of slabs of this process, shape (rows,)."""
        counts = np.sum([np.diff(points.slabs.first) for points in self._points], axis=0)
        return np.asarray(counts, float).reshape(-1, self._rows.across).sum(axis=1)

    def _begin_interval(self) -> None:
        self._left, self._began, self._waited = INTERVAL, time.perf_counter(), domain.group.waited

    def balance(self) -> None:
        """Before a step: now and then cut the rows anew, if some processes work longer than others. The time of a row is that
        of its process by the points in it. Which process does a slab changes no bit of the results."""
        self._left -= 1
        if self._left > 0:
            return
        worked = time.perf_counter() - self._began - (domain.group.waited - self._waited)
        count = self._count()
        cost = domain.group.total(count * (worked / max(count.sum(), 1.0)))
        hand_over = [points.hand_over() for points in self._points] if domain.would_pay(cost) else []
        if hand_over:
            domain.cut_again(cost)
        for take_up in hand_over:
            take_up()
        self._begin_interval()
