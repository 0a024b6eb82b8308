"""Quantities as functions of time: CSV files, and data models of the change in time of loads, pressures and gravity, which is a
smooth rise or a table of fractions."""

import csv
from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from itertools import pairwise
from math import isfinite
from typing import ClassVar

import numpy as np

from pellucid.model import InputFile, Model, check, parameter
from pellucid.smooth_step import risen
from pellucid.users.users_code import file_bytes


def read_rows(path: str, quantity: str, another: str = "") -> np.ndarray:
    """Read the rows of a CSV file: time [s] and a quantity, shape (rows, 2). quantity: name with unit for messages, such as
    "displacement [m]". A header row is allowed.

    If all rows have a third column, named `another` in messages, the shape is (rows, 3). Raises ValueError, which names
    the line of the file.
    """
    try:
        text = file_bytes(path).decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise ValueError(f"cannot read the table {path}: {reason}") from None
    rows: list[tuple[float, ...]] = []
    widths = (2, 3) if another else (2,)
    for number, cells in enumerate(_cells(text, path), start=1):
        if not cells or cells[0].lstrip().startswith("#") or (not rows and number == 1 and not _numbers(cells)):
            continue
        place = f"line {number} of {path}"
        if len(cells) not in (widths if not rows else (len(rows[0]),)) or not _numbers(cells):
            if rows:
                expected = f"{'three' if len(rows[0]) == 3 else 'two'} numbers like the first row"
            else:
                expected = "two or three numbers" if another else "two numbers"
            optional = f" and optionally {another}" if another else ""
            raise ValueError(f"{place} does not have {expected}; every row needs time [s], {quantity}{optional}")
        row = tuple(map(float, cells))
        if rows and row[0] <= rows[-1][0]:
            text = f"{place}: time {row[0]:g} s does not come after {rows[-1][0]:g} s"
            raise ValueError(f"{text}; sort the rows by time, each time once")
        rows.append(row)
    if len(rows) < 2:
        raise ValueError(f"the table {path} has {len(rows)} rows of numbers; it needs at least two")
    return np.array(rows)


def check_order(times: Sequence[float]) -> None:
    """Raise ValueError unless each time [s] is greater than the previous one."""
    for before, after in pairwise(times):
        if not before < after:
            raise ValueError(f"time {after:g} s does not come after {before:g} s; sort the times, each once")


def between_rows(rows: np.ndarray) -> Callable[[float], float]:
    """Return the quantity of a table, relative to its value at t = 0, as a function of time [s]; rows: time [s] and
    quantity, shape (n, 2).

    Monotone cubic interpolation between the rows, constant before the first and after the last row.
    """
    from scipy.interpolate import PchipInterpolator

    times, values = rows.T
    curve = PchipInterpolator(times, values)

    def within(t: float) -> float:
        return float(curve(min(max(t, times[0]), times[-1])))

    return lambda t: within(t) - within(0.0)


def steepest(rows: np.ndarray) -> float:
    """Return an upper bound of the absolute slope of the interpolation `between_rows`: 3 times the largest slope between two
    rows, which monotone cubics do not exceed."""
    return float(3.0 * np.abs(np.diff(rows[:, 1]) / np.diff(rows[:, 0])).max())


def _cells(text: str, path: str) -> Iterator[list[str]]:
    reader = csv.reader(text.splitlines())
    try:
        yield from reader
    except csv.Error as error:  # such as a cell of more than 131 072 characters
        raise ValueError(f"line {reader.line_num} of {path} cannot be read as CSV: {error}") from None


def _numbers(cells: list[str]) -> bool:
    try:
        return all(isfinite(float(cell)) for cell in cells)
    except ValueError:
        return False


class OverTime(Model):
    """A quantity as a function of time in a file. The file is read with the case, so that its errors are reported as errors
    of the case."""

    @abstractmethod
    def rows(self) -> np.ndarray:
        """Return time [s] and the quantity, shape (rows, 2). Raises ValueError, which names the line of the file."""

    @check
    def _read_it(self) -> None:
        self.rows()

    def function(self) -> Callable[[float], float]:
        """Return the quantity relative to its value at t = 0, as a function of time [s]."""
        return between_rows(self.rows())

    def top_speed(self) -> float:
        """Return an upper bound of the absolute rate of change of the quantity [its unit per second]."""
        return steepest(self.rows())


class Amplitude(Model):
    """Fraction of a load as a function of time: piecewise linear, constant before the first and after the last time."""

    times: tuple[float, ...] | None = parameter("s", "times of the table, in increasing order", None, min_length=2)
    shares: tuple[float, ...] | None = parameter("", "fraction of the load at each time; may be negative or above 1", None)
    path: InputFile | None = parameter(
        "", "alternative: a CSV file with the columns time [s] and fraction; a header row is allowed", None
    )

    @check
    def _is_a_function(self) -> None:
        if (self.path is None) == (self.times is None) or (self.times is None) != (self.shares is None):
            raise ValueError("give either `times` and `shares`, such as { times = [0, 1], shares = [0, 1] }, or `path`")
        if self.times is not None and self.shares is not None and len(self.times) != len(self.shares):
            raise ValueError(f"{len(self.times)} times and {len(self.shares)} shares; give the same number of both")
        check_order(self.times or ())
        self._rows  # noqa: B018 (a file is read at once, so that an error in it is one of the case)

    @cached_property
    def _rows(self) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Times [s] and fractions of the load at these times, as tuples, since models with arrays cannot be compared."""
        if self.path is not None:
            times, shares = read_rows(self.path, "share of the load").T.tolist()
            return tuple(times), tuple(shares)
        return self.times or (), self.shares or ()

    @property
    def largest(self) -> float:
        """Largest absolute value of the fraction of the load."""
        return max(abs(share) for share in self._rows[1])

    @property
    def smallest(self) -> float:
        """Smallest value of the fraction of the load; negative if the load reverses."""
        return min(self._rows[1])

    def at(self, time: float) -> float:
        """Return the fraction of the load at a time [s]."""
        times, shares = self._rows
        return float(np.interp(time, times, shares))


class ChangesInTime(Model):
    """Change of a load or pressure in time: a smooth rise, or an amplitude."""

    declared_anew: ClassVar[frozenset[str]] = frozenset()
    """Keys that a kind of load declares itself, with its own meaning."""

    rise: float = parameter("s", "duration of a smooth rise from zero", 0.0, ge=0)
    amplitude: Amplitude | None = parameter("", "alternative to `rise`: the fraction that acts, as a function of time", None)

    @check
    def _rises_once(self) -> None:
        rise, amplitude = self._change()
        if amplitude is not None and rise > 0.0:
            raise ValueError("`rise` and `amplitude` cannot be combined; remove one")

    def _change(self) -> tuple[float, Amplitude | None]:
        """Return the rise time [s] and the amplitude (None if not given). A key that a kind of load redefines
        (`declared_anew`) counts as not given."""
        own = self.declared_anew
        return 0.0 if "rise" in own else self.rise, None if "amplitude" in own else self.amplitude

    def key_of_change(self) -> str | None:
        """Return the key that changes the load in time; None if it is constant."""
        rise, amplitude = self._change()
        return "amplitude" if amplitude is not None else "rise" if rise > 0.0 else None

    def share(self, time: float) -> float:
        """Return the fraction of the load that acts at a time [s], as defined by `rise` or `amplitude`; 1 if neither is
        given."""
        rise, amplitude = self._change()
        return risen(time, rise) if amplitude is None else amplitude.at(time)
