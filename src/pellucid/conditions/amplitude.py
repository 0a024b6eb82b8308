"""Data models of the change in time of loads, pressures and gravity: a smooth rise, or a table of fractions."""

from functools import cached_property
from typing import ClassVar

import numpy as np

from pellucid.conditions.signals.time_table import check_order, read_rows
from pellucid.model import InputFile, Model, check, parameter
from pellucid.smooth_step import risen


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

    def share(self, time: float) -> float:
        """Return the fraction of the load that acts at a time [s], as defined by `rise` or `amplitude`; 1 if neither is
        given."""
        rise, amplitude = self._change()
        return risen(time, rise) if amplitude is None else amplitude.at(time)
