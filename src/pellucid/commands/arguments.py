"""Arguments that several commands share, and functions that read them."""

import shutil
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pellucid.errors import CaseError, UsageError

if TYPE_CHECKING:
    from rich.console import Console

    from pellucid.case import Case
    from pellucid.results.metrics import Metric


CaseArgument = Annotated[str, typer.Argument(metavar="CASE", help="A gallery id, such as gan2011/shock-tube, or a TOML file.")]
Settings = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="Set any key of the case, such as grid.cell=0.02; can be repeated."),
]
ChangedSettings = Annotated[
    list[str] | None,
    typer.Option(
        "--set", metavar="KEY=VALUE", help="Continue with another end time, time step, limit or output; can be repeated."
    ),
]
Quick = Annotated[bool, typer.Option("--quick", help="Use the quick settings of the case: a coarse, short run.")]


def read_threads(text: str) -> int:
    """Return the number of threads in the text of the option `--threads`. Raises UsageError for an invalid text."""
    from pellucid.jit import check_threads

    threads = int(text) if text.isascii() and text.isdecimal() else text
    check_threads(threads)
    return int(threads)


Threads = Annotated[
    int | None,
    typer.Option(
        "--threads",
        metavar="N",
        parser=read_threads,
        help="Number of threads (default: a run measures which number is fastest; bench uses all cores).",
    ),
]
Ranks = Annotated[
    int | None,
    typer.Option(
        "--ranks",
        metavar="N",
        min=1,
        help="Number of processes that share the run, started by mpiexec (extra mpi); the results do not depend on it.",
    ),
]
NoReport = Annotated[
    bool, typer.Option("--no-report", help="Draw no figures and write no report; run `pellucid report DIR` to do it later.")
]
Until = Annotated[
    str | None,
    typer.Option("--until", metavar="T", help='Simulated end time, rounded up to a whole step: 0.1 (s) or "20 ms".'),
]


def read_case(case: str, quick: bool, settings: list[str] | None, studied: Mapping[str, Any] | None = None) -> "Case":
    """Read a case (gallery id or path) with its quick settings and the user's settings "KEY=VALUE", and check it.

    `studied`: values of fields that a study replaces in every run, by dotted key; they are applied if the case is invalid
    without them. Raises CaseError.
    """
    from pellucid.case import load

    own = read_settings(settings)
    try:
        return load(case, own, quick)
    except CaseError:
        if not studied:
            raise
    return load(case, {**own, **studied}, quick)


def read_settings(settings: list[str] | None) -> dict[str, Any]:
    """Return the values of the options `--set KEY=VALUE` by key. Raises CaseError for an invalid text."""
    from pellucid.case import parse_setting

    return dict(parse_setting(text) for text in settings or ())


def read_time(option: str, text: str | None) -> float | None:
    """Return a positive time [s] from a text such as "0.1" or "20 ms"; None for None. Raises UsageError, which names the
    option."""
    from pellucid.units import UnitError, to_si

    if text is None:
        return None
    try:
        seconds = float(text)
    except ValueError:
        try:
            seconds = to_si(text, "s")
        except UnitError as error:
            raise UsageError(f"{option}: {error}") from None
    if not 0.0 < seconds < float("inf"):
        raise UsageError(f"{option} {text}: the time must be greater than 0 s and finite")
    return seconds


def print_table(header: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print aligned columns on stdout; on a terminal too narrow for them, long cells wrap."""
    from rich.table import Table

    table = Table(box=None, pad_edge=False, header_style="bold", padding=(0, 2, 0, 0))
    for name in header:
        table.add_column(name, overflow="fold")
    for row in rows:
        table.add_row(*row)
    console().print(table)


def console() -> "Console":
    """Return a rich console on stdout with the width of the terminal; in a pipe lines never wrap."""
    from rich.console import Console

    width = shutil.get_terminal_size().columns if sys.stdout.isatty() else 1000
    return Console(width=width, highlight=False, markup=False)


def number(value: float | None) -> str:
    """Format a number for a table cell; empty for None."""
    return "" if value is None else f"{value:.4g}"


def print_metrics(names: Mapping[str, Sequence[str]], metrics: Sequence["Metric"]) -> None:
    """Print metrics with their references, errors and tolerances as a table; print nothing if there are no metrics. names:
    additional first columns, by heading."""
    columns = ("value", "reference", "error", "tolerance")
    rows = [
        (*labels, *(number(getattr(metric, column)) for column in columns), "pass" if metric.passed else "fail")
        for *labels, metric in zip(*names.values(), metrics, strict=True)
    ]
    if rows:
        print_table((*names, *columns, ""), rows)
