"""Columns of a history as curves: times at which their values hold, and interpolation between rows.

Most columns hold the value at the time of the row. The reactions and torques of motions in time are means over the interval
since the previous row, so that their sum is the impulse. To second order such a mean f̄ is the value at the middle of the
interval Δt: f̄ = f(t - Δt/2) + f''Δt²/24. Checks, plots and fits read columns through this module.

In a steady analysis a reaction is the force at the equilibrium of its row.
"""

from collections.abc import Collection, Mapping

import numpy as np

MEAN_QUANTITIES = ("reaction", "torque")


class Readings:
    """Columns of a history, read as curves.

    history: columns by name, each of shape (rows,), with `time`. means: names of the columns that are means since the
    previous row. is_steady: True if the rows are equilibria; these are few and lie on smooth curves, so a cubic spline
    interpolates between them.
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


def mean_columns(probes: Collection[tuple[str, str]], is_steady: bool) -> tuple[str, ...]:
    """Return the names of the history columns whose values are means since the previous row; none in a steady analysis.

    probes: name and quantity of each probe.
    """
    return () if is_steady else tuple(name for name, quantity in probes if quantity in MEAN_QUANTITIES)
