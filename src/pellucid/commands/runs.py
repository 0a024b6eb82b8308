"""Commands on runs: run, resume, report, view."""

import os
import shutil
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pellucid.commands.arguments import (
    CaseArgument,
    ChangedSettings,
    NoReport,
    Quick,
    Ranks,
    Settings,
    Threads,
    Until,
    print_metrics,
    read_case,
    read_settings,
    read_time,
)
from pellucid.errors import CaseError, Interrupted, Terminated, UsageError
from pellucid.ranks.group import processes
from pellucid.system.extras import install_command

if TYPE_CHECKING:
    from pellucid.results.storage.run import Run


Folder = Annotated[Path, typer.Argument(metavar="DIR", help="The folder of a run.")]


def run(
    case: CaseArgument,
    quick: Quick = False,
    settings: Settings = None,
    until: Until = None,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out", metavar="DIR", help="Folder of the results; an earlier run in it is replaced (default: a new runs/NAME)."
        ),
    ] = None,
    threads: Threads = None,
    ranks: Ranks = None,
    every: Annotated[str | None, typer.Option("--every", metavar="T", help="Simulated time between frames.")] = None,
    no_report: NoReport = False,
) -> None:
    """Run a case; write its curves, fields, checkpoints, figures and report.html to DIR."""
    share(ranks)
    from pellucid.results.storage.run_folder import RunFolder

    chosen = read_case(case, quick, settings)
    end = read_time("--until", until)
    interval = read_time("--every", every)
    if interval is not None:
        try:
            chosen = chosen.with_settings({"output.frames": interval})
        except CaseError as error:
            raise error.blame(f"--every {every}") from None
    if out and processes.size == 1:
        RunFolder(out).check_replaceable()
    name = Path(case).stem if case.endswith(".toml") else chosen.id.rpartition("/")[2] or "case"
    folder = out or unused(Path("runs"), name)

    from pellucid.case import located
    from pellucid.progress import watching
    from pellucid.running.launch import run_case

    try:
        with watching() as progress, resumable(folder):
            wanted = {"report": not no_report, "foretell": True}
            folder = processes.told(folder)
            finished = run_case(chosen, folder, threads=threads, until=end, progress=progress, **wanted)
    except CaseError as error:  # what only the set-up of the run can find
        raise located(error, case, quick, settings or ()) from None
    conclude(finished, folder)


def resume(
    dir_: Folder,
    settings: ChangedSettings = None,
    until: Until = None,
    threads: Threads = None,
    ranks: Ranks = None,
    no_report: NoReport = False,
) -> None:
    """Continue a run from its last checkpoint; the results are bitwise the same as without the interruption."""
    share(ranks)
    end = read_time("--until", until)

    from pellucid.progress import watching
    from pellucid.running.launch import resume_case

    with watching() as progress, resumable(dir_):
        changes = read_settings(settings)
        finished = resume_case(dir_, end, threads, progress, not no_report, changes, foretell=True)
    conclude(finished, dir_)


def report(
    dir_: Folder,
    beside: Annotated[
        Path | None,
        typer.Option("--beside", metavar="DIR", help="Another run whose curves are drawn into the same figures of probes."),
    ] = None,
    pictures_of: Annotated[
        str | None,
        typer.Option("--from", metavar="FILE.toml", help="Use the pictures, films, plots and checks of this case from now on."),
    ] = None,
) -> None:
    """Draw the figures of a run again and write its report.html."""
    from pellucid.progress import watching
    from pellucid.results.report.report import write_report
    from pellucid.results.storage.run import Run
    from pellucid.results.storage.run_folder import RunFolder

    for folder in (dir_, *([beside] if beside else ())):
        RunFolder(folder).read_stored()  # says where there is no run
    if pictures_of is not None:
        from pellucid.results.storage.identity import with_pictures

        folder_of_run = RunFolder(dir_)
        retold = with_pictures(folder_of_run.read_case(), read_case(pictures_of, False, None))
        with folder_of_run.held():
            folder_of_run.write_case(retold)
    try:
        with watching() as progress:
            write_report(dir_, Run(beside) if beside else None, progress)
    except KeyboardInterrupt as error:
        text = (
            f"Interrupted: the report is not complete; the results in {dir_} are unchanged.\n    Run `pellucid report "
            f"{dir_}` to write it."
        )
        raise Interrupted(text, not isinstance(error, Terminated)) from None
    typer.echo(f"the report is {dir_ / 'report.html'}")


def view(dir_: Folder) -> None:
    """Open the report of a run in the browser, at the interactive 3-D view."""
    import webbrowser

    from pellucid.results.storage.run_folder import RunFolder

    folder = RunFolder(dir_)
    folder.read_stored()  # says where there is no run
    if not folder.report.is_file():
        raise UsageError(f"The run in {dir_} has no report yet.\n    Run `pellucid report {dir_}` to write it.")
    page = folder.report.resolve()
    if not webbrowser.open(f"{page.as_uri()}#view"):
        typer.echo("No browser was found. Copy the file to another machine and open it there; it needs no other files.")
    typer.echo(f"the report is {page}")


def share(ranks: int | None) -> None:
    """Replace this process by `ranks` MPI processes that share the command; do nothing for None. Raises UsageError if several
    processes already share it."""
    if ranks is None:
        return
    if processes.size > 1:
        text = f"--ranks {ranks} starts {ranks} processes, but mpiexec has already started {processes.size}"
        raise UsageError(f"{text}.\n    Remove --ranks, or run the command without mpiexec.")
    start_together(ranks, without("--ranks", sys.argv[1:]))


@contextmanager
def resumable(folder: Path) -> Iterator[None]:
    """Add the command that continues the run in `folder` to the message of an interruption in the block."""
    try:
        yield
    except Interrupted as error:
        raise Interrupted(
            f"{error}\n    Run `pellucid resume {folder}` to continue, or `pellucid report {folder}` to draw the "
            "results so far.",
            error.by_keyboard,
        ) from None
    except KeyboardInterrupt as error:  # outside of the steps
        raise Interrupted(what_is_left(folder), not isinstance(error, Terminated)) from None


def what_is_left(folder: Path) -> str:
    """Return the message for a run that was interrupted outside its steps: which results exist and how to continue."""
    from pellucid.results.storage.run_folder import RunFolder

    chosen = RunFolder(folder)
    if not (chosen.was_held_here and chosen.case.is_file()):
        return "The run was interrupted before its first step; nothing was written."
    if chosen.ended:
        return (
            f"Interrupted while the report was drawn; the results are complete.\n    Run `pellucid report {folder}` to draw it."
        )
    return f"The run was interrupted between its steps.\n    Run `pellucid resume {folder}` to continue."


def unused(parent: Path, name: str) -> Path:
    """Return the path of a new folder `parent/name`, with a number appended if it exists."""
    number = 1
    while (folder := parent / (name if number == 1 else f"{name}-{number}")).exists():
        number += 1
    return folder


def conclude(finished: "Run", folder: Path) -> None:
    """Print the result of a run (end time, steps, speed, metrics and folder)."""
    from pellucid.progress import clock

    if not processes.is_first:
        return
    summary = finished.summary
    typer.echo(
        f"done: t = {summary['end_time']:.6g} s after {summary['steps']} steps of {summary['points']} points, "
        f"run time {clock(summary['wall_seconds'])} ({summary['point_steps_per_second'] / 1e6:.3g} M point-steps/s)"
    )
    print_metrics({"metric": list(finished.metrics)}, list(finished.metrics.values()))
    typer.echo(f"results in {folder}")


COMMANDS = (run, resume, report, view)


LAUNCHER = "mpiexec"
INSTALL = f"Run {install_command('mpi')}, or install mpi4py for the MPI of the machine."


def start_together(processes: int, arguments: Sequence[str]) -> None:
    """Replace this process by the MPI launcher, which starts `processes` processes of this program with the command line
    `arguments`; do nothing for one process.

    Raises UsageError if MPI is not installed.
    """
    if processes == 1:
        return
    beside = Path(sys.executable).parent / LAUNCHER
    launcher = str(beside) if beside.is_file() else shutil.which(LAUNCHER)
    if launcher is None or find_spec("mpi4py") is None:
        missing = LAUNCHER if launcher is None else "mpi4py"
        raise UsageError(f"--ranks {processes} requires {missing}, which is not installed.\n    {INSTALL}")
    sys.stdout.flush()
    os.execv(launcher, [launcher, "-n", str(processes), sys.executable, "-m", "pellucid", *arguments])


def without(option: str, arguments: Sequence[str]) -> list[str]:
    """Return the arguments of a command line without the option `option`, such as "--ranks", and without its value."""
    left, skip = list[str](), False
    for argument in arguments:
        if not (skip or argument == option or argument.startswith(f"{option}=")):
            left.append(argument)
        skip = argument == option
    return left
