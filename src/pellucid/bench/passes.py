"""Kernels that loop over all points of a body (passes), measured one by one: time, and smallest memory traffic."""

import time
from collections.abc import Callable
from typing import Any

import numpy as np

from pellucid.bench.problem import case_of
from pellucid.bodies.points_on_grid import PointsOnGrid
from pellucid.simulation.simulation import Simulation

WARM_UP_STEPS = 3
ROUNDS = 7
SECONDS = 0.05  # of a round, about


def measure(
    body: str, points: int, threads: int | None, functions: str = "trilinear", transfer: str = "flip"
) -> dict[str, Any]:
    """Measure the wall-clock times of the passes (kernels that loop over all points) of the benchmark problem of a body; the
    fastest of `ROUNDS` rounds counts. Arguments as in `pellucid.bench.measure.measure`, keys of the result as in
    `pellucid.bench.whole.bench`."""
    simulation = Simulation(case_of(points, body, functions, transfer), threads=threads)
    for _ in range(WARM_UP_STEPS):
        simulation.step()
    subject = simulation.stages.grid_bodies[0]
    if not isinstance(subject, PointsOnGrid):
        raise TypeError(f"{body} is not a body of points on the grid")
    n = subject.n_points
    found = {name: _measured(alone.run, alone.traffic, n) for name, alone in subject.passes().items()}
    what = {"body": body, "functions": functions, "transfer": transfer}
    return {**what, "points": n, "threads": threads, "passes": found}


def _measured(run: Callable[[], None], traffic: list[np.ndarray], points: int) -> dict[str, float]:
    run()
    times = int(np.clip(SECONDS / max(_seconds(run, 1), 1e-9), 1, 1000))
    seconds = min(_seconds(run, times) for _ in range(ROUNDS)) / points
    size = sum(array.nbytes for array in traffic) / points
    return {"seconds_per_point": seconds, "bytes_per_point": size, "bytes_per_second": size / seconds}


def _seconds(run: Callable[[], None], times: int) -> float:
    start = time.perf_counter()
    for _ in range(times):
        run()
    return (time.perf_counter() - start) / times
