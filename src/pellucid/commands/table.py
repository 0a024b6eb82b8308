"""Tables on the terminal and in pipes."""

import shutil
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from rich.console import Console

    from pellucid.results.metrics import Metric


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
