"""Run a case in a folder, resume a run from its folder, and record the steps of a simulation in a script of the user."""

import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from tempfile import mkdtemp
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pellucid.compilation.reporting import compilation_told, laws_blamed
from pellucid.errors import CaseError, RunStopped, UsageError
from pellucid.jit import set_threads
from pellucid.progress import Progress, WarningsOnly, for_terminal
from pellucid.ranks.domain import domain
from pellucid.registry import Registry
from pellucid.results.run import Run
from pellucid.results.storage import checkpoint
from pellucid.results.storage.files import explained
from pellucid.results.storage.identity import check_bodies, check_case, check_start, with_changes
from pellucid.results.storage.probes import check_probes
from pellucid.results.storage.recorder import Recorder
from pellucid.results.storage.run_folder import RunFolder
from pellucid.results.storage.start import read_start
from pellucid.running.forecast import foretold, pace_learned
from pellucid.system.processes import helped

if TYPE_CHECKING:
    from pellucid.case import Case
    from pellucid.simulation.simulation import Simulation


class _Size(NamedTuple):
    """Size of a case, which decides whether `try_set_up` sets the case up."""

    points: int  # number of points of all bodies
    tables: float
    """Memory of the shape functions of meshless solids [bytes]."""


class _Asked(NamedTuple):
    """Options of a run or of its continuation, see `run_case`."""

    threads: int | None
    until: float | None
    progress: Progress
    report: bool
    foretell: bool


LARGE = _Size(1_000_000, 256 * 2**20)
"""Size of the largest case that `validate` sets up; this needs a few seconds once the kernels are compiled."""
NOT_SET_UP = (
    "set-up: not checked, because a case of this size takes long to set up; `pellucid run` checks it before the first step"
)


def run_case(
    case: "Case",
    out: Path | str | None = None,
    threads: int | None = None,
    until: float | None = None,
    progress: Progress | bool | None = None,
    report: bool = True,
    foretell: bool = False,
) -> Run:
    """Run a case from the start and write all results to `out`, by default a temporary folder that is removed with the returned
    run.

    `threads`: number of threads; by default the fastest number is measured. `until` [s] ends the run after the first step that
    reaches this time. `report=False` omits figures and report. `foretell` reports the expected number of steps before the run.
    `progress=True` shows the progress on a terminal or in a notebook. An earlier run in `out` is replaced.

    Raises `UsageError` if `case` is not a case, or if the folder contains other files or is in use; `RunStopped` after an error
    stop, whose state has been written for diagnosis; `Interrupted` after a checkpoint; `OutputError` if the disk is full.
    """
    from pellucid.case.spec import required

    domain.group.join()
    with domain.together():
        progress, case = seen(progress), required(case)
        _check_alike(case, out, until)
        check_until(until, case)
        if out is not None and domain.group.is_first:
            RunFolder(out).check_replaceable()  # before the set-up, which may be slow
            if case.start is not None and Path(case.start.path).resolve() == Path(out).resolve():
                text = (
                    f"The run in {out} is the initial state of the case (start.path).\n    Choose another folder for the "
                    "results."
                )
                raise UsageError(text)
        # before the folder is touched: a bad case erases nothing
        with _first_set_up(case, threads, progress) as (simulation, compiling, start):
            folder = RunFolder(mkdtemp(prefix="pellucid-") if out is None and domain.group.is_first else out or "")
            folder = domain.group.told(folder)
            recorder, asked = Recorder(folder, case, compiling, start=start), _Asked(threads, until, progress, report, foretell)
            if not domain.group.is_first:
                return _take_part(simulation, recorder, asked)
            with explained(folder.path), folder.made():
                if folder.case.is_file():
                    progress.note(f"replacing the earlier run in {folder.path}")
                for text in _contacts_on_nodes(simulation):
                    progress.note(text)
                folder.start(case)
                return _finish(simulation, recorder, asked, temporary=out is None)


def try_set_up(case: "Case", progress: Progress) -> list[str]:
    """Set a case up as `run_case` does, up to the first step, and discard the simulation. Used to check a case.

    Cases that are larger than `LARGE` take long to set up: their lines follow from the case alone.

    Returns
    -------
    list of str
        Lines for the user on the contact of membranes with other bodies, the time step, the number of steps and the run time.

    Raises
    ------
    CaseError
        If a run of the case would be refused.
    """
    from pellucid.case import check_memory
    from pellucid.case.memory import n_points, table_bytes
    from pellucid.running.forecast import foretell_case, foretell_simulation
    from pellucid.set_up.first_look import look
    from pellucid.set_up.overlap import contact_offsets

    check_memory(case)
    if n_points(case) > LARGE.points or table_bytes(case) > LARGE.tables:
        for text in look(case):
            warnings.warn(text, stacklevel=2)
        return [*contact_offsets(case), *foretell_case(case), NOT_SET_UP]
    with _first_set_up(case, None, progress, alone=True) as (simulation, _, _):
        from pellucid.contact.surface_pairs import SurfacePairs  # needs numba, whose threads the set-up chooses

        overlaps = simulation.parts.only(SurfacePairs).start_overlaps
        within = [f"contact: {overlap.text}" for overlap in overlaps if len(overlap.between) == 1]
        return [*contact_offsets(case), *_contacts_on_nodes(simulation), *within, *foretell_simulation(simulation)]


def _contacts_on_nodes(simulation: "Simulation") -> list[str]:
    """Return lines on the solids and membranes that are in contact on the nodes of the grid, with the reasons."""
    from pellucid.contact.pairs import ContactPairs

    return list(simulation.parts.only(ContactPairs).reasons)


def resume_case(
    out: Path | str,
    until: float | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
    report: bool = True,
    settings: Mapping[str, object] | None = None,
    foretell: bool = False,
) -> Run:
    """Resume the run in `out` from its last checkpoint, with bitwise identical results; without a checkpoint, restart the
    run from the beginning.

    `settings` change values that may change in a run, by dotted keys (`identity.MAY_CHANGE`: end, step, limits, output).
    until, threads, progress, report, foretell: see `run_case`. Raises `UsageError` if the folder contains no run or a
    setting may not change, and the errors of `run_case`.
    """
    asked = _Asked(threads, until, seen(progress), report, foretell)
    domain.group.join()
    folder = RunFolder(out)
    held = folder.held() if domain.group.is_first else nullcontext()
    with domain.together(), explained(folder.path), held:
        return _go_on(folder, settings or {}, asked)


def _go_on(folder: RunFolder, settings: Mapping[str, object], asked: _Asked) -> Run:
    threads, until, progress = asked[:3]
    try:
        try:
            case = folder.read_case()
        except CaseError:
            if not settings:
                raise
            case = folder.read_case(settings)  # which may correct a case file that was edited and is invalid
    except CaseError as error:
        raise UsageError(_why_not_resumed(folder, error)) from error
    if settings:
        case = with_changes(case, settings)
    check_until(until, case)
    found = _last_checkpoint(folder, progress)
    if found is None:
        progress.message(f"The run in {folder.path} has no checkpoint yet; it starts again from the beginning.")
        with _first_set_up(case, threads, progress) as (simulation, compiling, start):
            recorder = Recorder(folder, case, compiling, start=start)
            if not domain.group.is_first:
                return _take_part(simulation, recorder, asked)
            folder.start(case)
            if settings:
                folder.write_case(case)
            return _finish(simulation, recorder, asked)
    arrays, numbers = found
    recorded = numbers["recorder"]
    kept = recorded.get("identity", {})
    check_case(folder.path, case, kept)
    _same_inputs(case, recorded["inputs"])
    start = read_start(case, progress.message)
    check_start(folder.path, start, kept)
    with _simulation(case, threads, progress, start) as (simulation, compiling):
        check_bodies(folder.path, simulation.bodies, kept)
        simulation.restore(arrays, numbers["simulation"])
        if case.time.passed(simulation.time):
            text = f"time.end = {case.time.end:g} s, but the run in {folder.path} has already reached {simulation.time:g} s"
            raise UsageError(f"{text}.\n    Set a later time.end, or start a new run.")
        recorder = Recorder(folder, case, compiling, recorded, start)
        if not domain.group.is_first:
            return _take_part(simulation, recorder, asked)
        if settings:
            folder.write_case(case)
        if not recorder.resumes_record:
            folder.discard_record(case)
        return _finish(simulation, recorder, asked)


def _last_checkpoint(folder: RunFolder, progress: Progress) -> tuple[dict[str, np.ndarray], dict[str, Any]] | None:
    """Read arrays and numbers of the newest undamaged checkpoint; None if there is no checkpoint. With several processes,
    the first process searches before all others and renames damaged files."""
    found = checkpoint.read_latest(folder.checkpoint, progress.message) if domain.group.is_first else None
    domain.group.told(None)
    return found if domain.group.is_first else checkpoint.read_latest(folder.checkpoint, lambda text: None)


def _check_alike(case: "Case", out: Path | str | None, until: float | None) -> None:
    """Raise UsageError if the processes that were started together have different cases, folders (`out`) or end times
    (`until` [s])."""
    from pellucid.case import dumps

    asked = [dumps(case), str(out), until]
    if any(other != asked for other in domain.group.each(asked)):
        text = (
            f"{domain.group.size} processes were started together to share one run, but their cases, folders or end times "
            "differ"
        )
        raise UsageError(f"{text}.\n    Start all of them with the same arguments, or start each without mpiexec.")


def check_until(until: float | None, case: "Case") -> None:
    """Raise `UsageError` for a time [s] at which a run of the case cannot end."""
    if until is not None and not until > 0.0:
        raise UsageError(f"until = {until!r} must be a positive time [s].\n    Remove it to run to the end of the case.")
    if until is not None and case.time.passed(until):
        text = f"until = {until!r} s is later than the end of the case, time.end = {case.time.end!r} s"
        raise UsageError(f"{text}.\n    Remove it to run to the end of the case, or set a later time.end.")


@contextmanager
def _first_set_up(
    case: "Case", threads: int | None, progress: Progress, alone: bool = False
) -> Iterator[tuple[Any, Callable[[], float], dict[str, dict[str, np.ndarray]]]]:
    """Set up a case for a run from the start, with all checks before the first step.

    Yields the simulation, a function that returns the compilation time so far [s], and the arrays of bodies that continue
    an earlier run, by name. `alone`: True if no other process compiles kernels of later steps in advance.
    """
    start = read_start(case, progress.message)
    with _simulation(case, threads, progress, start, alone) as (simulation, compiling):
        check_probes(case.probe, simulation.bodies, case.periods)
        yield simulation, compiling, start


@contextmanager
def _simulation(
    case: "Case",
    threads: int | None,
    progress: Progress,
    start: Mapping[str, Mapping[str, Any]] | None = None,
    alone: bool = False,
) -> Iterator[tuple[Any, Callable[[], float]]]:
    """Build the simulation of a case and report which kernels are compiled.

    start: arrays of bodies that continue an earlier run, by name. Yields the simulation and a function that returns the
    compilation time so far [s]. `alone`: True if no other process compiles kernels of later steps in advance.
    """
    set_threads(threads)  # before numba is imported: more threads than cores can only be had then
    from pellucid.case import check_memory
    from pellucid.compilation.ahead import compiled_ahead
    from pellucid.compilation.reporting import kernel_key
    from pellucid.simulation.simulation import Simulation

    check_memory(case)
    progress.begin("setting up")
    ahead = nullcontext(lambda: None) if alone else compiled_ahead(case)
    with ahead as begin, compilation_told(progress, kernel_key(case), begin) as seconds, laws_blamed(case):
        yield Simulation(case, threads, start=start), seconds


def _why_not_resumed(folder: RunFolder, error: CaseError) -> str:
    """Return the message for a run whose case can no longer be read: the missing file or registration, and the remedy. error:
    the error from reading the case."""
    stored = folder.read_stored()
    found = checkpoint.read_latest(folder.checkpoint, lambda text: None)
    homes = found[1]["recorder"].get("kinds", {}) if found else {}
    lines = [f"The run in {folder.path} cannot continue, because its case can no longer be read:"]
    lines += [f"The file {path} is missing. Restore it." for path in stored.extensions if not Path(path).is_file()]
    for name, home in homes.items():
        if home not in stored.extensions and not any(name in registry.entries for registry in Registry.every):
            text = f'"{name}" was registered by {home}, which is not listed in `extensions` of the case'
            lines.append(f'{text}. Import it in a script that calls `pellucid.resume("{folder.path}")`.')
    if len(lines) == 1:
        lines += str(error).splitlines()
    lines.append(f'Its results can still be read with `pellucid report {folder.path}` or `pellucid.Run("{folder.path}")`.')
    return "\n    ".join(lines)


def _same_inputs(case: "Case", before: Mapping[str, str]) -> None:
    """Raise UsageError if an input file of the case has changed since the start of the run. before: digest of each file by path
    at the start, see `pellucid.results.storage.identity.digests`."""
    from pellucid.results.storage.identity import digests

    now = digests(case)
    for path, digest in before.items():
        if now.get(path) != digest:
            text = f"The input file {path} has changed since the run started."
            raise UsageError(f"{text}\n    Restore the old file to continue, or start a new run.")


def seen(progress: Progress | bool | None) -> Progress:
    """Return the object to which a run reports its progress. In a run with several processes only the first process shows
    the progress; all other processes show warnings only. progress: a display; True for a display that fits the terminal or
    notebook."""
    if progress is True:
        progress = for_terminal()
    return progress if progress and domain.group.is_first else WarningsOnly()


def _take_part(simulation: Any, recorder: Recorder, asked: _Asked) -> Run:
    """Compute the share of this process in a simulation that several processes share, if this process is not the first one,
    and wait until the first process has written the results. Returns the run. recorder: writer of the rows and checkpoints."""
    if asked.foretell:
        foretold(simulation, asked.until, WarningsOnly())
    _run_to_end(simulation, recorder, asked.until, None)
    domain.leave()
    domain.group.wait()
    return Run(recorder.folder.path)


def _run_to_end(simulation: Any, recorder: Recorder, until: float | None, progress: Progress | None) -> None:
    from pellucid.simulation.loop import recorded_steps

    for _ in recorded_steps(simulation, recorder, until, progress):
        pass


def _finish(simulation: Any, recorder: Recorder, asked: _Asked, temporary: bool = False) -> Run:
    folder, until, progress, report = recorder.folder, asked.until, asked.progress, asked.report
    if asked.foretell:
        progress = foretold(simulation, until, progress)
    try:
        with pace_learned(simulation, recorder) if domain.group.size == 1 else nullcontext():
            _run_to_end(simulation, recorder, until, progress)
        domain.leave()
    except RunStopped as error:
        if recorder.facts:  # it stopped itself in a step, not while it was set up
            folder.write_summary(recorder.facts, {})
            if report and not temporary:
                _report_stop(error, folder, progress)
        raise
    progress.begin("metrics")
    folder.write_summary(recorder.facts, {})
    run = Run(folder.path, temporary)
    if not report:
        folder.write_summary(recorder.facts, run.metrics)
        domain.group.wait()
        return run

    from pellucid.results.pictures.painter import drawing_helpers
    from pellucid.results.report.report import draw_report

    helpers = drawing_helpers(run)
    with helped(helpers):  # they get ready while the metrics are found
        folder.write_summary(recorder.facts, run.metrics)
        draw_report(run, progress=progress, helpers=helpers)
    domain.group.wait()
    return run


def _report_stop(error: RunStopped, folder: RunFolder, progress: Progress) -> None:
    """Draw the results of a run that stopped itself, and add the path of the report to the error. An error in drawing never
    hides the error of the run."""
    from pellucid.results.report.report import draw_report

    try:
        error.add_note(f"Curves and last pictures of the run: {draw_report(Run(folder.path), progress=progress)}")
    except Exception as trouble:
        error.add_note(f"The report of the run could not be drawn: {trouble}")


def recorded(
    simulation: "Simulation", out: Path | str, until: float | None = None, progress: Progress | bool | None = None
) -> Iterator["Simulation"]:
    """Step a simulation to the end of its case or to `until` [s], and write history, frames, checkpoints and summary to the
    folder `out`.

    Yields the simulation after each step. progress: True to show the progress, or a progress object. `pellucid.Run(out)`
    reads the results. If the loop ended early, `pellucid.resume(out)` continues the run. Raises the errors of
    `pellucid.run`.
    """
    from pellucid.simulation.loop import recorded_steps

    case, folder = simulation.case, RunFolder(out)
    check_until(until, case)
    check_probes(case.probe, simulation.bodies, case.periods)
    recorder = Recorder(folder, case, lambda: 0.0)
    if not domain.group.is_first:
        yield from recorded_steps(simulation, recorder, until)
        return
    with explained(folder.path), folder.made():
        folder.start(case)
        try:
            yield from recorded_steps(simulation, recorder, until, seen(progress))
        finally:
            folder.write_summary(recorder.facts, {})
        folder.write_summary(recorder.facts, Run(folder.path).metrics)
