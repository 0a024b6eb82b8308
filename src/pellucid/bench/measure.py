"""One measurement in a process of its own, so that its peak memory is its own."""

import json
import resource
import statistics
import sys
import time
from typing import Any

from pellucid.bench.problem import bench_case
from pellucid.simulation import Simulation

WARM_UP_STEPS = 3
BLOCKS = 3


def measure(body: str, points: int, steps: int, threads: int | None) -> dict[str, Any]:
    """Step the benchmark problem `BLOCKS` times `steps` steps; the median block counts. Keys as in `bench`."""
    Simulation(bench_case(body, 1000), threads=threads).step()  # compiles the kernels or loads them
    before = _peak_bytes()
    simulation = Simulation(bench_case(body, points), threads=threads)
    n = sum(b.n_points for b in simulation.bodies)
    _advance(simulation, WARM_UP_STEPS)
    seconds = statistics.median(_advance(simulation, steps) for _ in range(BLOCKS))
    memory = _peak_bytes() - before
    del simulation
    return {
        "body": body,
        "points": n,
        "steps": steps,
        "seconds_per_step": seconds / steps,
        "point_steps_per_second": n * steps / seconds,
        "bytes_per_point": memory / n,
        "peak_bytes": _peak_bytes(),
        "parts": _parts(body, points, steps, threads),
    }


def _parts(body: str, points: int, steps: int, threads: int | None) -> dict[str, float]:
    """Seconds a step in each part of the step, from a second run with its timers on."""
    simulation = Simulation(bench_case(body, points), threads=threads, timed=True)
    _advance(simulation, WARM_UP_STEPS)
    before = dict(simulation.timers)
    _advance(simulation, steps)
    return {part: (seconds - before.get(part, 0.0)) / steps for part, seconds in simulation.timers.items()}


def _advance(simulation: Simulation, steps: int) -> float:
    start = time.perf_counter()
    for _ in range(steps):
        simulation.step()
    return time.perf_counter() - start


def _peak_bytes() -> int:
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return peak if sys.platform == "darwin" else peak * 1024  # Linux counts in KiB


if __name__ == "__main__":
    sys.stdout.write(json.dumps(measure(**json.loads(sys.argv[1]))) + "\n")
