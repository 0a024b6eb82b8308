"""Verification: run cases and compare their metrics with references, and convergence studies: run a case for several values of
a field and compute the errors of a metric and the observed order."""

import csv
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any, NamedTuple

from pellucid import catalogue
from pellucid.case import Case
from pellucid.errors import RunStopped, UsageError
from pellucid.progress import Progress
from pellucid.results.metrics import Metric
from pellucid.running.launch import run_case
from pellucid.studies.ranges import at_key, named, read_values

if TYPE_CHECKING:
    from pellucid.results.storage.run import Run


class Row(NamedTuple):
    """Row of the table that `pellucid verify` shows: name of a case, name of one of its metrics, and the metric."""

    case: str
    name: str
    metric: Metric


def verify(
    ids: Sequence[str] | None = None,
    full: bool = False,
    out: Path | str | None = None,
    threads: int | None = None,
    progress: "Progress | None" = None,
) -> list[Row]:
    """Run gallery cases (default: all) or case files, in the quick or full variant, and return a row for every metric.

    With `out`, results are written to `out/<group>/<case>`, or to `out/<file name>` for a case file. A run that stops with
    an error gives a row that has not passed. Raises `CaseError` for an invalid case, `UsageError` for a case without a
    check.
    """
    from pellucid import catalogue
    from pellucid.case import load

    cases = {name: load(name) for name in ids or catalogue.ids()}
    for name, case in cases.items():
        if not (case.checks or catalogue.module(case.id)):
            raise UsageError(f"{name} has no metrics to verify.\n    Add a [[check]] to the case.")
    rows = []
    for name, case in cases.items():
        folder = Path(out) / (name if catalogue.has(name) else Path(name).stem) if out is not None else None
        if progress is not None:
            progress.message(f"{name} ...")
        variant = case if full else case.quick_variant()
        try:
            run = run_case(variant, folder, threads, progress=progress, report=folder is not None)
        except RunStopped as error:
            rows.append(_failure(name, f"the run stopped itself: {error}"))
            continue
        rows += [Row(name, label, metric) for label, metric in run.metrics.items()]
        if not run.metrics:
            rows.append(_failure(name, "the metrics could not be computed"))
    return rows


def _failure(case: str, what: str) -> Row:
    return Row(case, "run", Metric(math.nan, math.nan, math.inf, 0.0, "", what))


class Step(NamedTuple):
    """A row of the table of a convergence study, i.e. one run: value of the varied key, error of the metric, and ratio of
    errors and order of convergence relative to the previous run."""

    value: Any  # value of the varied key
    error: float  # error of the metric
    ratio: float | None  # error of the previous run divided by this error; None for the first run
    order: float | None  # order of convergence relative to the previous run; None for the first run


def read_sweep(texts: Sequence[str]) -> dict[str, list[Any]]:
    """Read the values of `--over` options such as "grid.cell=0.05,0.025"; return the values by key.

    Raises UsageError for a range, and unless every key has the same number of values, and at least two.
    """
    sweep = read_values(texts)
    for key, values in sweep.items():
        if isinstance(values, tuple):
            text = f"--over {key}={values[0]}:{values[1]}: a convergence study requires a list of values, not a range"
            raise UsageError(f"{text}.\n    Write KEY=V1,V2,..., for example grid.cell=0.05,0.025,0.0125.")
    sizes = {key: len(values) for key, values in sweep.items()}
    if min(sizes.values()) < 2:
        raise UsageError("--over requires at least two values, for example grid.cell=0.05,0.025.")
    if len(set(sizes.values())) > 1:
        counts = ", ".join(f"{key} {size}" for key, size in sizes.items())
        raise UsageError(f"All --over options must have the same number of values, but they have {counts}.")
    return sweep


def study(
    case: Case,
    sweep: dict[str, list[Any]],
    metric: str,
    out: Path | None = None,
    threads: int | None = None,
    progress: Progress | None = None,
) -> list[Step]:
    """Run a case for each row of values and return, for each run, the error of the metric named `metric` and the order of
    convergence.

    sweep: values by dotted key; the n-th run has the n-th value of every key, and the first key is the abscissa. out: folder in
    which the runs are kept; default: a temporary folder. Before any run, raises CaseError for an invalid value and UsageError
    for a metric that the case does not have.
    """
    from pellucid.running.launch import run_case

    known = (*(asked.name for asked in case.checks), *getattr(catalogue.module(case.id), "METRICS", ()))
    if metric not in known:
        raise UsageError(_unknown(metric, known, case.id or case.title))
    rows = [dict(zip(sweep, row, strict=True)) for row in zip(*sweep.values(), strict=True)]
    variants = [case.with_settings(row) for row in rows]
    steps: list[Step] = []
    abscissa = next(iter(sweep))
    with TemporaryDirectory(prefix="pellucid-") as scratch:
        for number, (row, variant) in enumerate(zip(rows, variants, strict=True), 1):
            if progress is not None:
                progress.message(named(row))
            run = run_case(variant, (out or Path(scratch)) / f"{number}", threads=threads, progress=progress)
            steps.append(_next_step(steps, at_key(variant, abscissa), _error(run, metric)))
    return steps


def observed_order(steps: Sequence[Step]) -> float | None:
    """Return the order of convergence: the least-squares slope of log error against log value; None unless all are positive
    numbers."""
    numbers = [(step.value, step.error) for step in steps]
    if not all(_positive(value) and _positive(error) for value, error in numbers):
        return None
    x = [math.log(value) for value, _ in numbers]
    y = [math.log(error) for _, error in numbers]
    mean_x, mean_y = sum(x) / len(x), sum(y) / len(y)
    spread = sum((a - mean_x) ** 2 for a in x)
    return sum((a - mean_x) * (b - mean_y) for a, b in zip(x, y, strict=True)) / spread if spread else None


def write_study(steps: Sequence[Step], key: str, metric: str, folder: Path) -> None:
    """Write convergence.csv and, if all values are positive numbers, the log-log figure convergence.png to a folder. key: the
    varied key; metric: name of the metric."""
    folder.mkdir(parents=True, exist_ok=True)
    with (folder / "convergence.csv").open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow((key, f"error_of_{metric}", "ratio", "order"))
        writer.writerows(steps)
    order = observed_order(steps)
    if order is None:
        return
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(5.0, 4.0), layout="constrained")
    FigureCanvasAgg(figure)
    axes = figure.add_subplot()
    axes.loglog([step.value for step in steps], [step.error for step in steps], "o-", label=f"observed order {order:.2f}")
    axes.set(xlabel=key, ylabel=f"error of {metric}")
    axes.grid(True, which="both", alpha=0.3)
    axes.legend()
    figure.savefig(folder / "convergence.png", dpi=150)


def _next_step(steps: Sequence[Step], value: Any, error: float) -> Step:
    if not steps or not (_positive(error) and _positive(steps[-1].error)):
        return Step(value, error, None, None)
    before = steps[-1]
    ratio = before.error / error
    comparable = _positive(value) and _positive(before.value) and value != before.value
    return Step(value, error, ratio, math.log(ratio) / math.log(before.value / value) if comparable else None)


def _error(run: "Run", metric: str) -> float:
    metrics = run.metrics
    if metric not in metrics:
        raise UsageError(f"With these settings, {_unknown(metric, metrics, run.case.id)}")
    return float(metrics[metric].error)


def _unknown(metric: str, known: Iterable[str], case: str) -> str:
    names = ", ".join(known) or "none; add a [[check]] to the case"
    return f"{case} has no metric `{metric}`; available: {names}"


def _positive(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool) and 0 < value < math.inf
