"""Loop over the steps of a simulation in a script of the user, with output to a folder."""

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

from pellucid.progress import Progress
from pellucid.ranks.domain import domain
from pellucid.results.run import Run
from pellucid.results.storage.files import explained
from pellucid.results.storage.probes import check_probes
from pellucid.results.storage.recorder import Recorder
from pellucid.results.storage.run_folder import RunFolder
from pellucid.running.launch import check_until, seen

if TYPE_CHECKING:
    from pellucid.simulation.simulation import Simulation


def recorded(
    simulation: "Simulation", out: Path | str, until: float | None = None, progress: Progress | bool | None = None
) -> Iterator["Simulation"]:
    """Step a simulation to the end of its case or to `until` [s], and write history, frames, checkpoints and summary to the
    folder `out`.

    Yields the simulation after each step. progress: True to show the progress, or a progress object. `pellucid.Run(out)`
    reads the results. If the loop ended early, `pellucid.resume(out)` continues the run. Raises the errors of
    `pellucid.run`.
    """
    case, folder = simulation.case, RunFolder(out)
    check_until(until, case)
    check_probes(case.probe, simulation.bodies, case.periods)
    recorder = Recorder(folder, case, lambda: 0.0)
    if not domain.group.is_first:
        yield from simulation.recorded(recorder, until)
        return
    with explained(folder.path), folder.made():
        folder.start(case)
        try:
            yield from simulation.recorded(recorder, until, seen(progress))
        finally:
            folder.write_summary(recorder.facts, {})
        folder.write_summary(recorder.facts, Run(folder.path).metrics)
