"""Signals: prescribed displacements as functions of time."""

from abc import abstractmethod
from collections.abc import Callable
from math import pi, sin
from typing import Literal

import numpy as np

from pellucid.conditions.signals.time_table import OverTime, read_rows
from pellucid.model import InputFile, Model, parameter
from pellucid.smooth_step import smooth_step

Displacement = Callable[[float], float]


class SignalModel(Model):
    """A displacement as a function of time. A new kind of signal is a subclass with its own `kind`."""

    kind: str

    @abstractmethod
    def function(self) -> Displacement:
        """Return the displacement [m] as a function of time [s]."""

    @abstractmethod
    def top_speed(self) -> float:
        """Return the largest absolute velocity [m/s], or an upper bound."""


class Sine(SignalModel):
    """A sine with amplitude a, period T and phase φ that starts at 0: u = a (sin(2π t/T + φ) - sin φ)."""

    kind: Literal["sine"] = "sine"
    amplitude: float = parameter("m", "amplitude a")
    period: float = parameter("s", "period T", gt=0)
    phase: float = parameter("rad", "phase φ", 0.0)

    def function(self) -> Displacement:
        return lambda t: self.amplitude * (sin(2.0 * pi * t / self.period + self.phase) - sin(self.phase))

    def top_speed(self) -> float:
        return abs(self.amplitude) * 2.0 * pi / self.period


class Ramp(SignalModel):
    """A smooth ramp from 0 to the displacement d, u = d s³(10 - 15 s + 6 s²) with s = (t - t₀)/T, for the start time t₀
    and the duration T."""

    kind: Literal["ramp"] = "ramp"
    distance: float = parameter("m", "final displacement d")
    duration: float = parameter("s", "duration T", gt=0)
    start: float = parameter("s", "start time t₀", 0.0, ge=0)

    def function(self) -> Displacement:
        return lambda t: self.distance * smooth_step((t - self.start) / self.duration)

    def top_speed(self) -> float:
        return 1.875 * abs(self.distance) / self.duration


class Steady(SignalModel):
    """A motion at constant velocity v: displacement u = v t."""

    kind: Literal["steady"] = "steady"
    velocity: float = parameter("m/s", "velocity v")

    def function(self) -> Displacement:
        return lambda t: self.velocity * t

    def top_speed(self) -> float:
        return abs(self.velocity)


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
