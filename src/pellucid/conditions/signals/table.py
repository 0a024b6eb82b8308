"""Signal (a prescribed displacement as a function of time): a table in a file."""

from typing import Literal

import numpy as np

from pellucid.conditions.signals.contract import SignalModel
from pellucid.conditions.signals.time_table import OverTime, read_rows
from pellucid.model import InputFile, parameter


class Table(OverTime, SignalModel):
    """A table of time [s] and displacement [m]: monotone cubic interpolation, constant before the first and after the last
    row.

    The displacement is relative to that at t = 0. Source of the interpolation: Fritsch & Butland 1984, SIAM J. Sci. Stat.
    Comput. 5, 300, as in scipy's PCHIP.
    """

    kind: Literal["table"] = "table"
    path: InputFile = parameter("", "CSV file with the columns time [s] and displacement [m]; a header row is allowed")

    def rows(self) -> np.ndarray:
        return read_rows(self.path, "displacement [m]")
