"""Duration of the steps of the benchmark problem, and its memory."""

import time
from typing import Any

from pellucid.bench.machine import peak_bytes
from pellucid.bench.problem import case_of
from pellucid.simulation.simulation import Simulation

WARM_UP_STEPS = 3
BLOCKS = 3


def measure(
    body: str, points: int, steps: int, threads: int | None, functions: str = "trilinear", transfer: str = "flip"
) -> dict[str, Any]:
    """Run the benchmark problem of a body for `BLOCKS` blocks of `steps` steps and return the results of the fastest block.
    Keys of the result as in `pellucid.bench.whole.bench`.

    body: name in `MATERIALS` or `MEMBRANES`. points: approximate number of points. functions, transfer: shape functions of the
    grid and velocity transfer, as in a case.
    """
    what = body, functions, transfer
    Simulation(case_of(1000, *what), threads=threads).step()  # compiles the kernels or loads them
    before = peak_bytes()
    simulation = Simulation(case_of(points, *what), threads=threads, timed=True)
    n = sum(b.n_points for b in simulation.bodies)
    _advance(simulation, WARM_UP_STEPS)
    simulation.timers.clear()
    blocks = [_advance(simulation, steps) for _ in range(BLOCKS)]
    seconds, processor_seconds = min(blocks)
    shares = {part: spent / sum(block[0] for block in blocks) for part, spent in simulation.timers.items()}
    return {
        "body": body,
        "functions": functions,
        "transfer": transfer,
        "points": n,
        "threads": threads,
        "steps": steps,
        "seconds_per_step": seconds / steps,
        "point_steps_per_second": n * steps / seconds,
        "cores": processor_seconds / seconds,
        "bytes_per_point": (peak_bytes() - before) / n,
        "peak_bytes": peak_bytes(),
        "parts": {**shares, "rest": 1.0 - sum(shares.values())},
    }


def _advance(simulation: Simulation, steps: int) -> tuple[float, float]:
    """Advance by a number of steps; return wall-clock time and processor time [s]."""
    start, processor_start = time.perf_counter(), time.process_time()
    for _ in range(steps):
        simulation.step()
    return time.perf_counter() - start, time.process_time() - processor_start
