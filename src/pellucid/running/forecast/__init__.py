"""Forecast of a run before it begins: step limit, number of steps, run time on this machine."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from pellucid.errors import UsageError
from pellucid.progress import Progress

if TYPE_CHECKING:
    from pellucid.results.storage.recorder import Recorder


def foretold(simulation: Any, until: float | None, progress: Progress) -> Progress:
    """Show the forecast (step limit, number of steps, run time) when a run begins or resumes. Returns the progress object
    for the run: `progress`, or an object that forwards to `progress` and also shows the run time after the first second, if
    the run time is unknown before.

    until: time at which the run ends [s]; default: end of the case.
    """
    from pellucid.running.forecast.on_the_way import ToldOnTheWay
    from pellucid.running.forecast.steps import of_simulation
    from pellucid.running.forecast.words import WIDE, lines, pace_of

    each, ahead = pace_of(simulation.case), of_simulation(simulation, until)
    for line in lines(simulation.case, ahead, each):
        progress.note(line)
    known = each is not None and each.most <= WIDE * each.least
    return progress if known or simulation.case.steady is not None else ToldOnTheWay(progress)


@contextmanager
def pace_learned(simulation: Any, recorder: "Recorder") -> Iterator[None]:
    """Store the wall-clock time per step of the block for later forecasts, also if the block ends with an error. The block runs
    the simulation; `recorder` counts the time."""
    from numba import config

    from pellucid.running.forecast.pace import Paces

    steps, seconds = simulation.n_steps, recorder.wall_seconds()
    try:
        yield
    finally:
        settled = simulation.facts().get("settled", {}).get("steps", 0) if steps == 0 else 0
        if not config.DISABLE_JIT:
            with suppress(UsageError):  # there is no folder
                Paces().learn(simulation.case, simulation.n_steps - steps + settled, recorder.wall_seconds() - seconds)
