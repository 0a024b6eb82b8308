"""Measured curves: a CSV file with a row of names, a row of units and rows of numbers, for comparison with a probe of a
case."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.case.measured import CurveError, Table, read_table
from pellucid.errors import UsageError
from pellucid.findings import absent
from pellucid.results.readings import Readings, mean_columns
from pellucid.results.storage.probes import ProbeReader
from pellucid.results.storage.run import Run
from pellucid.units import UnitError, to_si

if TYPE_CHECKING:
    from pellucid.case import Case

DEVIATION = "deviation"
TIME = "time"


FINE = 2001
"""Number of times at which an abscissa is sampled when it is inverted by linear interpolation."""
EXTRAPOLATED = 0.1
"""Largest extrapolation of a steady analysis, as a fraction of its range of abscissae."""


class NotReached(UsageError):
    """Error for measured values that lie beyond the end of a run."""


class Curve(NamedTuple):
    """Measured curve of a probe (its values against time or against another probe), in SI units, from a CSV file."""

    path: Path  # the CSV file
    probe: str  # name of the probe
    against: str
    """Name of the abscissa of the curve: `time` or another probe."""
    x: np.ndarray
    """Measured abscissae, shape (n,); `y` and `deviation` have the same shape."""
    y: np.ndarray  # measured values of the probe
    deviation: np.ndarray
    """Standard deviations of the values; if none are stated, the spread of the values, so that all curves have equal
    weight."""
    is_stated: bool  # True if standard deviations are given by the file or the user
    unit: str  # SI unit of the values

    def residuals(self, run: Run) -> np.ndarray:
        """Return the computed minus the measured values of the probe, divided by the standard deviations, shape (n,)."""
        return (self.values(run) - self.y) / self.deviation

    def values(self, run: Run) -> np.ndarray:
        """Return the values of the probe in a run at the measured abscissae, shape (n,).

        A steady analysis is extrapolated linearly by up to a tenth of its range, because the end of its range may depend on the
        parameters, e.g. if the abscissa is a force. Raises NotReached if measured abscissae lie further outside the run.
        """
        x, y = self._branch(run)
        if self._beyond(x) > (EXTRAPOLATED if _is_smooth(run) and self.against != TIME else 1e-6) * np.ptp(x):
            raise NotReached(
                f"{self._reach(x, run)}; extend the run, e.g. by a later `time.end`, or remove the rows beyond its end"
            )
        return _read(x, y, self.x, _is_smooth(run))

    def extrapolation(self, run: Run) -> str | None:
        """Return a text for the user about measured values beyond the end of a run; None if there are none."""
        x, _ = self._branch(run)
        return self._reach(x, run) if self._beyond(x) > 1e-6 * np.ptp(x) else None

    def interpolation_error(self, run: Run) -> np.ndarray:
        """Estimate the error of `values` between the rows of the run as the difference of two interpolants, shape (n,)."""
        x, y = self._branch(run)
        return np.abs(_read(x, y, self.x, True) - _read(x, y, self.x, False))

    def distance_to_rows(self, run: Run) -> float:
        """Return the largest distance of a measured abscissa from the nearest row of a run's history, divided by the range of
        abscissae of the run."""
        x, _ = self._branch(run)
        apart = np.abs(self.x[:, None] - x).min(axis=1)
        return float(apart[(self.x >= x[0]) & (self.x <= x[-1])].max(initial=0.0) / np.ptp(x))

    def instants(self, run: Run) -> np.ndarray:
        """Return the load times [s] at which the abscissa (a probe) of a steady run has the measured values, shape (k,); values
        outside the range of the run are omitted."""
        x, times = self._branch(run, along=TIME)
        if len(x) < 2:
            return times
        forward = np.argsort(times)
        fine = np.union1d(np.linspace(times.min(), times.max(), FINE), times)
        passed = _read(times[forward], x[forward], fine, _is_smooth(run))  # smooth in time, while its inverse may be steep
        sign = 1.0 if times[-1] > times[0] else -1.0
        passed = np.maximum.accumulate(sign * passed)
        wanted = self.x[(self.x >= x[0]) & (self.x <= x[-1])]
        return np.asarray(np.interp(sign * wanted, passed, fine))

    def _branch(self, run: Run, along: str = "") -> tuple[np.ndarray, np.ndarray]:
        """Return abscissae and ordinates of a run in order of ascending abscissae, up to the first turning point of the
        abscissa. along: history column of the ordinates, by default the probe."""
        x, y = run.readings.curve(along or self.probe, self.against, whole=True)
        known = np.isfinite(x) & np.isfinite(y)
        if not known.any():
            raise UsageError(f"{self.path}: {self.probe} and {self.against} of the run in {run.out} have no finite values")
        x, y = x[known], y[known]
        sign = 1.0
        if self.against != TIME:
            sign = 1.0 if x[np.argmax(np.abs(x - x[0]))] >= x[0] else -1.0
        new = np.concatenate([[True], sign * x[1:] > np.maximum.accumulate(sign * x)[:-1]])
        x, y = x[new], y[new]
        return (x, y) if sign > 0.0 else (x[::-1], y[::-1])

    def _beyond(self, x: np.ndarray) -> float:
        """Return the largest distance by which measured abscissae lie outside the range of a run; 0 if all lie inside. x:
        ascending abscissae of the run."""
        return float(max(x[0] - self.x.min(), self.x.max() - x[-1], 0.0))

    def _reach(self, x: np.ndarray, run: Run) -> str:
        measured = f"the measured {self.against} ranges from {self.x.min():.6g} to {self.x.max():.6g}"
        return f"{self.path}: {measured}, but in the run in {run.out} from {x[0]:.6g} to {x[-1]:.6g}"


def _is_smooth(run: Run) -> bool:
    """Return True if a run is a steady analysis, whose history is a smooth curve through few equilibria. Motions in time have
    many rows, jumps and noise."""
    return run.stored.steady is not None


def _read(x: np.ndarray, y: np.ndarray, at: np.ndarray, smooth: bool) -> np.ndarray:
    """Return the values at abscissae `at` of the curve through the points (x, y): a cubic spline if `smooth`, otherwise a
    monotone piecewise cubic; extrapolated linearly."""
    from scipy.interpolate import CubicSpline, PchipInterpolator

    if len(x) < 2:
        return np.full(len(at), y[0])
    cubic, within = (CubicSpline if smooth else PchipInterpolator)(x, y), np.clip(at, x[0], x[-1])
    return np.asarray(cubic(within) + (at - within) * cubic(within, 1))


def read_curve(path: Path, probe: str, case: "Case", deviation: str | float | None = None) -> Curve:
    """Read a measured curve for a probe of a case.

    The abscissa is the column `time` or the name of another probe, by default the first column. The ordinate is the column
    with the name of the probe, by default the second column. Standard deviations are in the column `deviation` or
    `<probe>_deviation`; without it, the argument `deviation`, a number in SI units or a text with a unit, applies to all
    values. The second row has the units, with or without a leading #. Raises UsageError with file and line.
    """
    units = {TIME: "s", **ProbeReader(case.probe).units()}
    if probe not in units or probe == TIME:
        raise UsageError(absent("the case has no probe", probe, [name for name in units if name != TIME]))
    try:
        return _curve(read_table(path), probe, case, units, deviation)
    except CurveError as error:
        raise UsageError(f"--measured: {error}") from None


def _curve(table: Table, probe: str, case: "Case", units: Mapping[str, str], deviation: str | float | None) -> Curve:
    path, names, lines = table.path, list(table.values), table.lines
    across = TIME if TIME in names else next((name for name in names if name in units and name != probe), "")
    if not across:
        raise CurveError(f"{path}:1: no column has the name time or the name of a probe; the columns are {', '.join(names)}")
    along = probe if probe in names else next((name for name in names if name != across and DEVIATION not in name), "")
    if not along:
        raise CurveError(f"{path}:1: no column has the name {probe}; the columns are {', '.join(names)}")
    if len(lines) < 2:
        raise CurveError(f"{path}: a curve requires at least two rows of numbers")
    unit = units[probe]
    x, y = _columns(table, across, along, probe, case, units)
    lines = lines[-len(y) :]
    stated = next((name for name in (f"{probe}_{DEVIATION}", DEVIATION) if name in names), None)
    if across == TIME and (wrong := np.flatnonzero((x < 0.0) | np.array([case.time.passed(t) for t in x]))).size:
        where = f"{path}:{lines[wrong[0]]}: t = {x[wrong[0]]:.6g} s"
        raise CurveError(
            f"{where} is not between 0 and time.end = {case.time.end:g} s; set a later time.end, or remove the row"
        )
    if stated is not None and deviation is not None:
        text = f"--deviation {deviation}: {path} already has standard deviations in the column {stated}"
        raise UsageError(f"{text}.\n    Remove the option or the column.")
    if stated is not None:
        spread = table.column(stated, unit)[-len(y) :]
        where = f"{path}:{lines[int(np.argmin(spread))]}: {stated}"
    else:
        spread = np.full(len(y), float(np.std(y)) if deviation is None else _in_si(deviation, unit))
        where = f"{path}: the spread of {along}" if deviation is None else f"--deviation {deviation}"
    if not spread.min() > 0.0:
        raise UsageError(f"{where} is {spread.min():g}; it must be greater than 0")
    return Curve(path, probe, across, x, y, spread, stated is not None or deviation is not None, unit)


def _columns(table: Table, across: str, along: str, probe: str, case: "Case", units: Mapping[str, str]) -> list[np.ndarray]:
    """Return abscissae and values of a measured curve in SI units. If the table is the history of a run, columns that are means
    over an interval are evaluated at the middle of the interval, as in the fitted run.

    table: columns of the CSV file. across, along: names of its columns of abscissae and values. probe: name of the probe.
    units: SI units of time and of the probes.
    """
    x, y = table.column(across, units[across]), table.column(along, units[probe])
    if along != probe or not {TIME, "step", "dt"} <= table.values.keys():
        return [x, y]
    means = mean_columns([(each.name, each.quantity) for each in case.probe], case.steady is not None)
    history = {TIME: table.column(TIME, "s"), across: x, along: y}
    return list(Readings(history, means).curve(along, across))


def _in_si(deviation: str | float, unit: str) -> float:
    try:
        return float(deviation)
    except ValueError:
        try:
            return to_si(str(deviation), unit)
        except UnitError as error:
            raise UsageError(f"--deviation {deviation}: {error}") from None
