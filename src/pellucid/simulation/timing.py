"""Computing times of the stages of a step, for `pellucid bench`."""

import time
from collections.abc import Callable
from typing import Any

OF_A_STEP = {
    "sort": "sort",
    "clear_nodes": "grid",
    "before_forces": "grid",
    "before_stress": "grid",
    "find_contact": "contact",
    "before_momentum": "viscosity",
    "advance_momentum": "grid",
    "stop_approach": "contact",
    "after_momentum": "grid",
    "find_strain_velocities": "grid",
    "particle_to_grid": "scatter",
    "grid_to_particle": "velocities",
    "update_stress": "gradients and law",
    "update_positions": "move",
    "predict_own_nodes": "scatter",
    "correct_own_nodes": "velocities",
    "update_own_nodes": "gradients and law",
}


def time_stages(simulation: Any, timers: dict[str, float]) -> None:
    """Make a simulation measure the wall-clock time of the stages of its steps. The time of each stage [s] is added to an entry
    of `timers`, such as "grid" or "contact"."""
    parts = [(simulation, {"record": "reductions"}), (simulation.stages, OF_A_STEP)]
    for owner, stages in parts:
        for stage, part in stages.items():
            setattr(owner, stage, _timed(timers, part, getattr(owner, stage)))


def _timed(timers: dict[str, float], part: str, stage: Callable[..., None]) -> Callable[..., None]:
    def timed(*arguments: Any, **named: Any) -> None:
        start = time.perf_counter()
        stage(*arguments, **named)
        timers[part] = timers.get(part, 0.0) + time.perf_counter() - start

    return timed
