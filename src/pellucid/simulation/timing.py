"""How long the verbs of a step take, for `pellucid bench`."""

import time
from collections.abc import Callable
from typing import Any

OF_ALL = {
    "sort": "sort",
    "clear": "grid",
    "find_pressures": "grid",
    "find_shifts": "grid",
    "detect_contact": "contact",
    "advance": "grid",
    "project": "grid",
    "give_second_impulses": "contact",
    "record": "reductions",
    "particle_to_grid": "scatter",
    "update_velocities": "velocities",
    "update_stress": "gradients and law",
}
ON_THE_GRID = {"update_positions": "move"}
ON_OWN_NODES = {"predict": "scatter", "correct": "velocities", "update": "gradients and law"}


def time_verbs(simulation: Any, timers: dict[str, float]) -> None:
    """Let the verbs of a simulation and of its bodies add their time [s] to that of their part in `timers`."""
    parts = [(simulation, OF_ALL)]
    parts += [(body, ON_THE_GRID) for body in simulation.grid_bodies]
    parts += [(body, ON_OWN_NODES) for body in simulation.nodal_bodies]
    for owner, verbs in parts:
        for verb, part in verbs.items():
            setattr(owner, verb, _timed(timers, part, getattr(owner, verb)))


def _timed(timers: dict[str, float], part: str, verb: Callable[..., None]) -> Callable[..., None]:
    def timed(*arguments: Any, **named: Any) -> None:
        start = time.perf_counter()
        verb(*arguments, **named)
        timers[part] = timers.get(part, 0.0) + time.perf_counter() - start

    return timed
