"""Measured curves: a CSV file with a row of names, a row of units and numbers, beside a probe of a case."""

import csv
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.errors import UsageError
from pellucid.findings import absent
from pellucid.results.storage.probes import ProbeReader
from pellucid.results.storage.run import Run
from pellucid.studies.ranges import readable
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
    names, said, rows, lines = _read(path)
    across = TIME if TIME in names else next((name for name in names if name in units and name != probe), "")
    if not across:
        raise UsageError(f"{path}:1: no column is named time or like a probe; it has {', '.join(names)}")
    along = probe if probe in names else next((name for name in names if name != across and DEVIATION not in name), "")
    if not along:
        raise UsageError(f"{path}:1: no column is named {probe}; it has {', '.join(names)}")

    def column(name: str, unit: str) -> np.ndarray:
        index = names.index(name)
        return np.array([row[index] for row in rows]) * _factor(path, name, said[index], unit)

    x, y, unit = column(across, units[across]), column(along, units[probe]), units[probe]
    stated = next((name for name in (f"{probe}_{DEVIATION}", DEVIATION) if name in names), None)
    if across == TIME and (wrong := np.flatnonzero((x < 0.0) | np.array([case.time.passed(t) for t in x]))).size:
        where = f"{path}:{lines[wrong[0]]}: t = {x[wrong[0]]:.6g} s"
        raise UsageError(f"{where} is not between 0 and the end of the case, time.end = {case.time.end:g} s; set that later")
    if stated is not None:
        spread = column(stated, unit)
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


def _factor(path: Path, name: str, said: str, unit: str) -> float:
    """By which numbers of a column are multiplied to be in SI units."""
    if said in ("", "1", "-") and unit in ("", "1"):
        return 1.0
    try:
        return to_si(f"1 {said}", unit if unit != "1" else "")
    except UnitError as error:
        raise UsageError(f"{path}:2: the unit of {name}: {error}") from None


def _read(path: Path) -> tuple[list[str], list[str], list[list[float]], list[int]]:
    """Names, units, numbers, and the lines of the file that these stand in."""
    with readable(path, "--measured"), path.open(newline="", encoding="utf-8-sig") as file:
        lines = [(n, [cell.strip() for cell in row]) for n, row in enumerate(csv.reader(file), 1) if any(map(str.strip, row))]
    if len(lines) < 4:
        raise UsageError(f"{path}: a row of names, such as time,force, a row of units, such as s,mN, and two rows of numbers")
    names, units = lines[0][1], [cell.lstrip("#").strip() for cell in lines[1][1]]
    if all(_is_number(cell) for cell in units):
        raise UsageError(f"{path}:2: numbers stand where units are expected, such as s,mN")
    _same_length(path, lines[1], names)
    return names, units, [_numbers(path, line, names) for line in lines[2:]], [number for number, _ in lines[2:]]


def _numbers(path: Path, line: tuple[int, list[str]], names: Sequence[str]) -> list[float]:
    _same_length(path, line, names)
    for name, cell in zip(names, line[1], strict=True):
        if not _is_number(cell):
            raise UsageError(f'{path}:{line[0]}: {name} = "{cell}" is no finite number')
    return [float(cell) for cell in line[1]]


def _same_length(path: Path, line: tuple[int, list[str]], names: Sequence[str]) -> None:
    if len(line[1]) != len(names):
        raise UsageError(f"{path}:{line[0]}: {len(line[1])} cells below {len(names)} names, {', '.join(names)}")


def _is_number(text: str) -> bool:
    try:
        return bool(np.isfinite(float(text)))
    except ValueError:
        return False
