"""What a run will take, told before it begins: what bounds its step, how many steps that makes, and how long they take here."""

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any

from pellucid.errors import UsageError
from pellucid.progress import Progress

if TYPE_CHECKING:
    from pellucid.results.storage.recorder import Recorder


def foretold(simulation: Any, until: float | None, progress: Progress) -> Progress:
    """Tell the user what a run will take as the run begins or goes on; returns the progress for the run, which tells later what
    is not known yet."""
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
    """Remember how long the steps of the block took, however the block ends."""
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
