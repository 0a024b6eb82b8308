"""Verification: run cases and compare their metrics with references."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from pellucid.errors import RunStopped, UsageError
from pellucid.progress import Progress
from pellucid.results.metrics import Metric
from pellucid.running.launch import run_case


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
