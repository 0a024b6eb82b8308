"""The metrics that a case asks for with its checks."""

from collections.abc import Callable, Mapping
from math import inf, nan
from typing import Any

import numpy as np

from pellucid.case.judgement import Check, in_si
from pellucid.case.measured import CurveError
from pellucid.results.metrics import Metric

TAKE: dict[str, Callable[[np.ndarray], Any]] = {
    "last": lambda values: values[-1],
    "largest": np.nanmax,
    "smallest": np.nanmin,
    "mean": np.nanmean,
    "largest-size": lambda values: np.nanmax(np.abs(values)),
}


def metric_of(asked: Check, history: Mapping[str, np.ndarray], units: Mapping[str, str]) -> Metric:
    """What a check finds in the columns of a history, each of shape (rows,)."""
    values, times = history[asked.column], history["time"]
    unit = "" if (named := units[asked.column]) == "1" else named
    try:
        found, wanted, error, size, words = _compared(asked, times, values, unit)
    except CurveError as gone:  # the run is done and its results are whole, whatever became of a file beside
        return Metric(nan, nan, inf, 0.0, unit, f"cannot be judged: {gone}")
    tolerance = size * asked.relative_tolerance if asked.relative_tolerance else in_si(asked.tolerance or nan, unit)
    meaning = "; ".join(filter(None, (asked.meaning, words, asked.source)))
    return Metric(found, wanted, error, tolerance, unit, meaning)


def _compared(asked: Check, times: np.ndarray, values: np.ndarray, unit: str) -> tuple[float, float, float, float, str]:
    """What was found, what should have been, how far apart they are, how large the reference is, and how it was taken."""
    if asked.curve is None:
        wanted = in_si(asked.reference if asked.reference is not None else nan, unit)
        if asked.at is None:
            found, words = float(TAKE[asked.take](values)), f"{asked.take.replace('-', ' ')} value of {asked.column}"
        else:
            found, words = float(np.interp(asked.at, times, values, nan, nan)), f"{asked.column} at {asked.at:g} s"
        return found, wanted, abs(found - wanted), abs(wanted), words.replace("_", " ")
    when, right, _ = asked.curve.read("s", unit)
    reached = (when >= times[0]) & (when <= times[-1])
    words = (
        f"rms of the differences between {asked.column} and {asked.curve.title}, at {reached.sum()} of its {len(when)} points"
    )
    size = float(np.abs(right).max())
    if not reached.any():
        return nan, nan, nan, size, words
    found = np.interp(when[reached], times, values)
    apart = float(np.sqrt(np.mean((found - right[reached]) ** 2)))
    return apart, 0.0, apart, size, words.replace("_", " ")
