"""A table of displacements in a file."""

from typing import Literal

import numpy as np
from pydantic import model_validator

from pellucid.conditions.signals.contract import Displacement, SignalModel
from pellucid.model import InputFile, parameter
from pellucid.time_table import read_rows


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
        return read_rows(self.path, "displacement [m]")

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
