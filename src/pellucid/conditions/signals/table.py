"""A table of displacements in a file."""

import csv
from math import isfinite
from typing import Literal

import numpy as np
from pydantic import model_validator

from pellucid.conditions.signals.contract import Displacement, SignalModel
from pellucid.input_files import file_bytes
from pellucid.model import InputFile, parameter


class Table(SignalModel):
    """A table of time [s] and displacement [m]: monotone cubics between the rows, constant before and behind.

    The displacement counts from that at t = 0. Source of the interpolation: Fritsch & Butland 1984, SIAM J. Sci. Stat.
    Comput. 5, 300, as in scipy's PCHIP.
    """

    kind: Literal["table"] = "table"
    path: InputFile = parameter("", "CSV file with the columns time [s] and displacement [m]; a row of names may stand first")

    @model_validator(mode="after")
    def _read_it(self) -> "Table":
        self.rows()
        return self

    def rows(self) -> np.ndarray:
        """The table, shape (rows, 2). Raises ValueError naming the file's line."""
        try:
            text = file_bytes(self.path).decode("utf-8-sig")
        except (OSError, UnicodeDecodeError) as error:
            reason = error.strerror if isinstance(error, OSError) else "it is no text in UTF-8"
            raise ValueError(f"cannot read the table {self.path}: {reason}") from None
        rows: list[tuple[float, float]] = []
        for number, cells in enumerate(csv.reader(text.splitlines()), start=1):
            if not cells or cells[0].lstrip().startswith("#") or (not rows and number == 1 and not _numbers(cells)):
                continue
            place = f"line {number} of {self.path}"
            if len(cells) != 2 or not _numbers(cells):
                raise ValueError(f"{place} has other cells than two numbers; every row has time [s], displacement [m]")
            row = float(cells[0]), float(cells[1])
            if rows and row[0] <= rows[-1][0]:
                raise ValueError(
                    f"{place}: time {row[0]:g} s does not come after {rows[-1][0]:g} s; put the rows in the order of "
                    f"time, each time once"
                )
            rows.append(row)
        if len(rows) < 2:
            raise ValueError(f"the table {self.path} has {len(rows)} rows of numbers; it needs at least two")
        return np.array(rows)

    def function(self) -> Displacement:
        """Displacement [m] as a function of time [s]."""
        from scipy.interpolate import PchipInterpolator

        times, values = self.rows().T
        curve = PchipInterpolator(times, values)

        def within(t: float) -> float:
            return float(curve(min(max(t, times[0]), times[-1])))

        return lambda t: within(t) - within(0.0)

    def top_speed(self) -> float:
        """Largest velocity [m/s] between rows, at most 3 times the slope of a row to the next with monotone cubics."""
        rows = self.rows()
        return float(3.0 * np.abs(np.diff(rows[:, 1]) / np.diff(rows[:, 0])).max())


def _numbers(cells: list[str]) -> bool:
    try:
        return all(isfinite(float(cell)) for cell in cells)
    except ValueError:
        return False
