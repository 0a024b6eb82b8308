"""A table of displacements in a file."""

from typing import Literal

import numpy as np
from pydantic import model_validator

from pellucid.conditions.signals.contract import Displacement, SignalModel
from pellucid.conditions.signals.time_table import between_rows, read_rows, steepest
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
        return read_rows(self.path, "displacement [m]")

    def function(self) -> Displacement:
        """Displacement [m] as a function of time [s]."""
        return between_rows(self.rows())

    def top_speed(self) -> float:
        """Largest velocity [m/s] between rows."""
        return steepest(self.rows())
