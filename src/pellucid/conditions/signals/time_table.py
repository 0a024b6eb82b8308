"""CSV files with a quantity as a function of time."""

import csv
from abc import abstractmethod
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from math import isfinite

import numpy as np

from pellucid.model import Model, check
from pellucid.system.input_files import file_bytes


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
