"""Metrics of a run: readings of its history as curves, computed values with references and errors, checks of the case."""

import math
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from math import inf, nan
from typing import Any

import numpy as np

from pellucid.case.judgement import Check, in_si
from pellucid.case.measured import CurveError


class Readings:
    """Columns of a history, read as curves.

    history: columns by name, each of shape (rows,), with `time`. means: names of the columns that are means since the
    previous row. is_steady: True if the rows are equilibria; these are few and lie on smooth curves, so a cubic spline
    interpolates between them.

    Most columns hold the value at the time of the row. The reactions and torques of motions in time are means over the interval
    since the previous row, so that their sum is the impulse. To second order such a mean f̄ is the value at the middle of the
    interval Δt: f̄ = f(t - Δt/2) + f''Δt²/24.

    In a steady analysis a reaction is the force at the equilibrium of its row.
    """

    def __init__(self, history: Mapping[str, np.ndarray], means: Collection[str] = (), is_steady: bool = False) -> None:
        self._history, self._means, self._is_steady = history, frozenset(means), is_steady

    @property
    def span(self) -> tuple[float, float]:
        """Times of the first and the last row of the history [s]."""
        times = self._history["time"]
        return float(times[0]), float(times[-1])

    def curve(self, y: str, x: str = "time", whole: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Return the column `y` against the column `x`, both at the same instants.

        If one of the two columns is a mean since the previous row, the instants are the middles of the intervals between
        rows, and values at rows are averaged to the middles. Otherwise the instants are the times of the rows.

        Parameters
        ----------
        whole
            True to extrapolate the values at the middles linearly to the first and the last row.

        Returns
        -------
        abscissae, ordinates : arrays of shape (rows,) or (intervals,), with `whole` (intervals + 2,)
        """
        if not self._means.intersection((x, y)) or len(self._history["time"]) < 2:
            return self._history[x], self._history[y]
        return self._at_middles(x, whole), self._at_middles(y, whole)

    def at(self, y: str, instants: "np.ndarray | float") -> np.ndarray:
        """Return the column `y` interpolated at times [s] (`instants`), NaN outside the history.

        The interpolation is linear, in a steady analysis a cubic spline.
        """
        times, values = self.curve(y, whole=True)
        linear = np.asarray(np.interp(instants, times, values, np.nan, np.nan))
        if not self._is_splined(times, values):
            return linear
        from scipy.interpolate import CubicSpline

        return np.where(np.isnan(linear), np.nan, CubicSpline(times, values)(instants))

    def first_time(self, y: str, value: float) -> float:
        """Return the first time [s] at which the column `y`, interpolated as in `at`, equals `value`; NaN if the column
        never reaches `value`."""
        times, values = self.curve(y, whole=True)
        above = values - value
        rows = np.flatnonzero(above[:-1] * above[1:] <= 0.0)
        if not len(rows):
            return float("nan")
        first, last, before, after = *times[rows[0] : rows[0] + 2], *above[rows[0] : rows[0] + 2]
        if before * after < 0.0 and self._is_splined(times, values):
            from scipy.optimize import brentq

            return float(brentq(lambda time: float(self.at(y, time)) - value, first, last, xtol=1e-12 * times[-1]))
        part = before / (before - after) if before != after else 0.0
        return float(first + part * (last - first))

    def _is_splined(self, times: np.ndarray, values: np.ndarray) -> bool:
        return self._is_steady and len(times) > 2 and bool(np.isfinite(values).all() and (np.diff(times) > 0.0).all())

    def _at_middles(self, name: str, whole: bool) -> np.ndarray:
        times, values = np.asarray(self._history["time"]), np.asarray(self._history[name])
        passed = np.flatnonzero(np.diff(times) > 0.0)
        ends = values[[0, -1]]
        middles = 0.5 * (times[passed] + times[passed + 1])
        found = values[passed + 1] if name in self._means else 0.5 * (values[passed] + values[passed + 1])
        if not whole:
            return found
        if name in self._means:
            ends = found[[0, -1]]
            if len(found) > 1:
                slopes = np.diff(found)[[0, -1]] / np.diff(middles)[[0, -1]]
                ends = ends + slopes * (times[[0, -1]] - middles[[0, -1]])
        return np.concatenate([ends[:1], found, ends[1:]])


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
        instant = asked.at
        if (event := asked.when) is not None:
            instant = readings.first_time(event.column, in_si(event.reaches, _unit(units, event.column)))
        found, wanted, error, size, words = _compared(asked, readings, instant, unit)
    except CurveError as gone:  # the run is done and its results are whole, whatever became of a file beside
        return Metric(nan, nan, inf, 0.0, unit, f"could not be evaluated: {gone}")
    tolerance = size * asked.relative_tolerance if asked.relative_tolerance else in_si(asked.tolerance or nan, unit)
    meaning = "; ".join(filter(None, (asked.meaning, words, asked.source)))
    return Metric(found, wanted, error, tolerance, unit, meaning)


def _unit(units: Mapping[str, str], column: str) -> str:
    return "" if units[column] == "1" else units[column]


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


MEAN_QUANTITIES = ("reaction", "torque")


def mean_columns(probes: Collection[tuple[str, str]], is_steady: bool) -> tuple[str, ...]:
    """Return the names of the history columns whose values are means since the previous row; none in a steady analysis.

    probes: name and quantity of each probe.
    """
    return () if is_steady else tuple(name for name, quantity in probes if quantity in MEAN_QUANTITIES)
