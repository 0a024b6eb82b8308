"""Metrics of a run: computed values with their references and errors, and the evaluation of the checks of a case."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import inf, nan
from typing import Any

import numpy as np

from pellucid.case.judgement import Check, Passing, in_si
from pellucid.case.measured import CurveError
from pellucid.results.readings import Readings


@dataclass(frozen=True)
class Metric:
    """A computed value of a run (`value`) with its `reference`, the `error` and the `tolerance` of the error; `meaning`
    describes the comparison for the report."""

    value: float
    reference: float
    error: float
    """Error of the value relative to the reference, as defined in `meaning`; not negative."""
    tolerance: float
    unit: str = ""
    """Unit of value and reference; empty for a pure number."""
    meaning: str = ""

    @property
    def passed(self) -> bool:
        """True if the error is within the tolerance; False if it is not a number."""
        return bool(self.error <= self.tolerance)

    def to_data(self) -> dict[str, Any]:
        """Return the value, reference, error and tolerance of the metric and the flag `pass` by name, for `summary.json`;
        numbers that are not finite become null."""
        return {
            "value": finite(self.value),
            "reference": finite(self.reference),
            "error": finite(self.error),
            "tolerance": finite(self.tolerance),
            "pass": self.passed,
        }


def finite(number: float) -> float | None:
    """Return the number; None if it is NaN or infinite, because JSON has no such numbers."""
    return float(number) if math.isfinite(number) else None


TAKE: dict[str, Callable[[np.ndarray], Any]] = {
    "last": lambda values: values[-1],
    "largest": np.nanmax,
    "smallest": np.nanmin,
    "mean": np.nanmean,
    "largest-size": lambda values: np.nanmax(np.abs(values)),
}
ROW = {"time-of-largest": np.nanargmax, "time-of-smallest": np.nanargmin}


def metric_of(asked: Check, readings: Readings, units: Mapping[str, str]) -> Metric:
    """Evaluate a check of the case (`asked`) on the history of a run, and return its metric: computed value, reference
    value, error and tolerance.

    readings: columns of the history. units: unit of each column, by name. If a file with a reference curve cannot be read,
    the error of the metric is infinite.
    """
    unit = "s" if asked.takes_time else _unit(units, asked.column)
    try:
        instant = asked.at if asked.when is None else _passed(asked.when, readings, units)
        found, wanted, error, size, words = _compared(asked, readings, instant, unit)
    except CurveError as gone:  # the run is done and its results are whole, whatever became of a file beside
        return Metric(nan, nan, inf, 0.0, unit, f"could not be evaluated: {gone}")
    tolerance = size * asked.relative_tolerance if asked.relative_tolerance else in_si(asked.tolerance or nan, unit)
    meaning = "; ".join(filter(None, (asked.meaning, words, asked.source)))
    return Metric(found, wanted, error, tolerance, unit, meaning)


def _unit(units: Mapping[str, str], column: str) -> str:
    return "" if units[column] == "1" else units[column]


def _passed(passing: Passing, readings: Readings, units: Mapping[str, str]) -> float:
    """Return the first time [s] at which a column of the history reaches a value (the event `passing` of a check); NaN if
    the column never reaches the value. units: unit of each column, by name."""
    return readings.first_time(passing.column, in_si(passing.reaches, _unit(units, passing.column)))


def _compared(asked: Check, readings: Readings, instant: float | None, unit: str) -> tuple[float, float, float, float, str]:
    """Evaluate the check `asked` at the time `instant` [s], or over all rows of the history if `instant` is None.

    Returns the computed value, the reference value, the error, the magnitude of the reference (for the relative tolerance), and
    a description of the comparison. For a reference curve, computed value and error are the root mean square of the difference
    from the curve. unit: SI unit of the result.
    """
    times, values = readings.curve(asked.column)
    if asked.curve is None:
        wanted = in_si(asked.reference if asked.reference is not None else nan, unit)
        if asked.takes_time:
            row = ROW[asked.take](values) if np.isfinite(values).any() else None
            found, words = nan if row is None else float(times[row]), f"{asked.take.replace('-', ' ')} value of {asked.column}"
        elif instant is None:
            found, words = float(TAKE[asked.take](values)), f"{asked.take.replace('-', ' ')} value of {asked.column}"
        else:
            found = float(readings.at(asked.column, instant)) if instant == instant else nan
            at = f"at {asked.at:g} s" if asked.when is None else f"when {asked.when.column} reaches {asked.when.reaches}"
            words = f"{asked.column} {at}"
        return found, wanted, abs(found - wanted), abs(wanted), words.replace("_", " ")
    when, right, _ = asked.curve.read("s", unit)
    all_found = readings.at(asked.column, when)
    first, last = readings.span
    reached = (when >= first) & (when <= last)
    words = (
        f"root mean square difference of {asked.column} and {asked.curve.title}, at {reached.sum()} of its {len(when)} points"
    )
    size = float(np.abs(right).max())
    if not reached.any():
        return nan, nan, nan, size, words
    apart = float(np.sqrt(np.mean((all_found[reached] - right[reached]) ** 2)))
    return apart, 0.0, apart, size, words.replace("_", " ")
