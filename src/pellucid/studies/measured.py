"""Measured curves: a CSV file with a row of names, a row of units and numbers, beside a probe of a case."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.case.measured import CurveError, Table, read_table
from pellucid.errors import UsageError
from pellucid.findings import absent
from pellucid.results.storage.probes import ProbeReader
from pellucid.results.storage.run import Run
from pellucid.units import UnitError, to_si

if TYPE_CHECKING:
    from pellucid.case import Case

DEVIATION = "deviation"
TIME = "time"


class Curve(NamedTuple):
    """Values that a probe was measured to have, in SI units."""

    path: Path
    probe: str
    against: str
    """`time` or the name of another probe."""
    x: np.ndarray
    """Of shape (n,), as `y` and `deviation`."""
    y: np.ndarray
    deviation: np.ndarray
    """Standard deviations; where none are stated the spread of the values, so that curves weigh alike."""
    is_stated: bool
    unit: str

    def residuals(self, run: Run) -> np.ndarray:
        """Differences of a run to the measurements over their deviations, shape (n,)."""
        return (self.values(run) - self.y) / self.deviation

    def values(self, run: Run) -> np.ndarray:
        """The probe of a run where it was measured, shape (n,). Raises UsageError where the run does not get there."""
        x, y = run.history[self.against], run.history[self.probe]
        if self.against != TIME:  # a path that turns back is followed to its first turn
            sign = 1.0 if x[np.argmax(np.abs(x - x[0]))] >= x[0] else -1.0
            new = np.concatenate([[True], sign * x[1:] > np.maximum.accumulate(sign * x)[:-1]])
            x, y = x[new], y[new]
        order = np.argsort(x)
        slack = 1e-6 * np.ptp(x)
        if self.x.min() < x.min() - slack or self.x.max() > x.max() + slack:
            reach = f"from {x.min():.6g} to {x.max():.6g}, and measured is from {self.x.min():.6g} to {self.x.max():.6g}"
            raise UsageError(f"{self.path}: {self.against} of the run in {run.out} goes {reach}: let the case go further")
        return np.interp(self.x, x[order], y[order])


def read_curve(path: Path, probe: str, case: "Case", deviation: str | float | None = None) -> Curve:
    """A curve for a probe of a case.

    Its columns: `time` or another probe, by name, or the first one; the probe by name, or the second one; `deviation`, or
    `<probe>_deviation`, the standard deviation. Without that column `deviation` is that of all values, a number in SI units or
    a text with a unit. The second row has units, with or without # before them. Raises UsageError with file and line.
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
        raise CurveError(f"{path}:1: no column is named time or like a probe; it has {', '.join(names)}")
    along = probe if probe in names else next((name for name in names if name != across and DEVIATION not in name), "")
    if not along:
        raise CurveError(f"{path}:1: no column is named {probe}; it has {', '.join(names)}")
    if len(lines) < 2:
        raise CurveError(f"{path}: one row of numbers; a curve has two or more")
    x, y, unit = table.column(across, units[across]), table.column(along, units[probe]), units[probe]
    stated = next((name for name in (f"{probe}_{DEVIATION}", DEVIATION) if name in names), None)
    if across == TIME and (wrong := np.flatnonzero((x < 0.0) | np.array([case.time.passed(t) for t in x]))).size:
        where = f"{path}:{lines[wrong[0]]}: t = {x[wrong[0]]:.6g} s"
        raise CurveError(f"{where} is not between 0 and the end of the case, time.end = {case.time.end:g} s; set that later")
    if stated is not None and deviation is not None:
        text = f"--deviation {deviation}: {path} has standard deviations of its own, in the column {stated}"
        raise UsageError(f"{text}; leave the option out, or the column")
    if stated is not None:
        spread = table.column(stated, unit)
        where = f"{path}:{lines[int(np.argmin(spread))]}: {stated}"
    else:
        spread = np.full(len(y), float(np.std(y)) if deviation is None else _in_si(deviation, unit))
        where = f"{path}: the spread of {along}" if deviation is None else f"--deviation {deviation}"
    if not spread.min() > 0.0:
        raise UsageError(f"{where} is {spread.min():g}; it must be greater than 0")
    return Curve(path, probe, across, x, y, spread, stated is not None or deviation is not None, unit)


def _in_si(deviation: str | float, unit: str) -> float:
    try:
        return float(deviation)
    except ValueError:
        try:
            return to_si(str(deviation), unit)
        except UnitError as error:
            raise UsageError(f"--deviation {deviation}: {error}") from None
