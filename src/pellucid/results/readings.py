"""Columns of a history as curves: at which instants their values hold, and how they are read between rows.

Most columns hold the value at the time of the row. The reactions and torques of motions in time are means over the interval
since the row before, so that their sum is the impulse; to second order such a mean is the value in the middle of the interval:
f̄ = f(t - Δt/2) + f''Δt²/24. All that compares a column with something else reads it here: checks, plots, fits.

In a steady analysis a reaction is the force at the equilibrium of its row.
"""

from collections.abc import Collection, Mapping

import numpy as np

MEAN_QUANTITIES = ("reaction", "torque")


class Readings:
    """A history whose columns are read as curves.

    history: columns by name, each of shape (rows,), with `time`. means: names of the columns that are means since the row
    before.
    """

    def __init__(self, history: Mapping[str, np.ndarray], means: Collection[str] = ()) -> None:
        self._history, self._means = history, frozenset(means)

    @property
    def span(self) -> tuple[float, float]:
        """The times of the first and the last row [s]."""
        times = self._history["time"]
        return float(times[0]), float(times[-1])

    def curve(self, y: str, x: str = "time", whole: bool = False) -> tuple[np.ndarray, np.ndarray]:
        """Return a column against another one, both at the same instants.

        These are the instants of the rows, or the middles of the intervals between them if one of the two is a mean. Values at
        rows are averaged to the middles.

        Parameters
        ----------
        whole
            Whether means are continued linearly to the first and the last row.

        Returns
        -------
        abscissae, ordinates : arrays of shape (rows,) or (intervals,), with `whole` (intervals + 2,)
        """
        if not self._means.intersection((x, y)) or len(self._history["time"]) < 2:
            return self._history[x], self._history[y]
        return self._at_middles(x, whole), self._at_middles(y, whole)

    def at(self, y: str, instants: "np.ndarray | float") -> np.ndarray:
        """Return a column at instants [s], linear between its values; not a number where the history has none."""
        times, values = self.curve(y, whole=True)
        return np.asarray(np.interp(instants, times, values, np.nan, np.nan))

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
    """Return the names of the columns that are means since the row before, of probes by name and quantity."""
    return () if is_steady else tuple(name for name, quantity in probes if quantity in MEAN_QUANTITIES)
