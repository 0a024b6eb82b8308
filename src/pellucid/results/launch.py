"""From a case to a finished run in a folder, and from a folder on."""

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Any

from pellucid.compiling import compilation_told
from pellucid.errors import UsageError
from pellucid.jit import set_threads
from pellucid.progress import Progress, WarningsOnly
from pellucid.results.storage import checkpoint
from pellucid.results.storage.recorder import Recorder
from pellucid.results.storage.run import Run
from pellucid.results.storage.run_folder import RunFolder

if TYPE_CHECKING:
    from pellucid.case import Case


def run_case(
    case: "Case",
    out: Path | str | None = None,
    threads: int | None = None,
    until: float | None = None,
    progress: Progress | None = None,
    report: bool = True,
) -> Run:
    """Run a case from the start and leave everything in `out`; without it in a folder that goes with the returned run.

    `until` [s] stops early, `report=False` leaves out figures and report. Raises `UsageError` for a folder with other
    files in it, `RunStopped` after a forensic dump, `Interrupted` after a checkpoint, `OutputError` for a full disk.
    """
    progress = progress or WarningsOnly()
    with _simulation(case, threads, progress) as simulation:  # before the folder is touched: a bad case erases nothing
        folder = RunFolder(mkdtemp(prefix="pellucid-") if out is None else out)
        folder.start(case)
        return _finish(simulation, Recorder(folder, case), until, progress, report, temporary=out is None)


def resume_case(
    out: Path | str,
    until: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    report: bool = True,
) -> Run:
    """Go on with the run in `out` from its last checkpoint, bit for bit; from the start where it has none yet.

    Raises `UsageError` where there is no run, otherwise as `run_case`.
    """
    progress = progress or WarningsOnly()
    folder = RunFolder(out)
    case = folder.read_case()
    with _simulation(case, threads, progress) as simulation:
        found = checkpoint.read_latest(folder.checkpoint, progress.message)
        if found is None:
            progress.message(f"there is no checkpoint in {folder.path} yet: the run begins again")
            folder.start(case)
            return _finish(simulation, Recorder(folder, case), until, progress, report)
        arrays, numbers = found
        _same_inputs(case, numbers["recorder"].get("inputs", {}))
        simulation.restore(arrays, numbers["simulation"])
        folder.reopen()
        return _finish(simulation, Recorder(folder, case, numbers["recorder"]), until, progress, report)


@contextmanager
def _simulation(case: "Case", threads: int | None, progress: Progress) -> Iterator[Any]:
    """The simulation of a case; what is compiled for it is told."""
    set_threads(threads)  # before numba is imported: more threads than cores can only be had then
    from pellucid.case import check_memory
    from pellucid.simulation.simulation import Simulation, kernel_key

    check_memory(case)
    progress.begin("setting up")
    with compilation_told(progress, kernel_key(case)):
        yield Simulation(case, threads)


def _same_inputs(case: "Case", before: Mapping[str, str]) -> None:
    """Raises UsageError where a file that the case reads is not the one that the run began with."""
    from pellucid.case.inputs import digests

    now = digests(case)
    for path, digest in before.items():
        if now.get(path) != digest:
            raise UsageError(f"{path} has changed since the run began: put the old file back to go on, or start a new run")


def _finish(
    simulation: Any,
    recorder: Recorder,
    until: float | None,
    progress: Progress,
    report: bool,
    temporary: bool = False,
) -> Run:
    simulation.run(recorder, until=until, progress=progress)
    progress.begin("metrics")
    folder = recorder.folder
    folder.write_summary(recorder.facts, {})
    run = Run(folder.path, temporary)
    folder.write_summary(recorder.facts, run.metrics)
    if report:
        from pellucid.results.report.report import write_report

        write_report(run, progress=progress)
    return run
