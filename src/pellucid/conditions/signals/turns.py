"""Prescribed rotations as functions of time: the same signals as for displacements, with an angle instead of a distance.

This module also checks the values of user-defined displacements and rotations. Errors are reported with file and line.
"""

from abc import abstractmethod
from math import isfinite, radians
from typing import Literal

import numpy as np
from pydantic import field_validator

from pellucid.conditions.signals.displacements import Displacement, Ramp, SignalModel, Sine, Steady
from pellucid.conditions.signals.time_table import OverTime, read_rows
from pellucid.errors import RunStopped
from pellucid.model import InputFile, Model, parameter
from pellucid.units import in_degrees
from pellucid.users.users_code import failing_as, home_of

SAID = 'in degrees, or a text with a unit such as "0.3 rad"'


class TurnModel(Model):
    """A rotation as a function of time. A new kind of rotation is a subclass with its own `kind`."""

    kind: str

    _in_degrees = field_validator("angle", mode="before", check_fields=False)(in_degrees)

    @abstractmethod
    def function(self) -> Displacement:
        """Return the angle [rad] as a function of time [s]."""

    @abstractmethod
    def top_speed(self) -> float:
        """Return the largest absolute angular velocity [rad/s], or an upper bound."""


class LikeDisplacement(TurnModel):
    """A rotation whose angle [rad] is given by a displacement signal."""

    @abstractmethod
    def signal(self) -> SignalModel:
        """Return the displacement signal whose value [m] as a function of time is the angle [rad]."""

    def function(self) -> Displacement:
        return self.signal().function()

    def top_speed(self) -> float:
        return self.signal().top_speed()


class RampTurn(LikeDisplacement):
    """A smooth ramp from 0 to the angle α, θ = α s³(10 - 15 s + 6 s²) with s = (t - t₀)/T, for the start time t₀ and the
    duration T."""

    kind: Literal["ramp"] = "ramp"
    angle: float = parameter("", f"final angle α {SAID}")
    duration: float = parameter("s", "duration T", gt=0)
    start: float = parameter("s", "start time t₀", 0.0, ge=0)

    def signal(self) -> SignalModel:
        return Ramp(distance=radians(self.angle), duration=self.duration, start=self.start)


class SineTurn(LikeDisplacement):
    """A sine with amplitude α, period T and phase φ that starts at 0: θ = α (sin(2π t/T + φ) - sin φ)."""

    kind: Literal["sine"] = "sine"
    angle: float = parameter("", f"amplitude α {SAID}")
    period: float = parameter("s", "period T", gt=0)
    phase: float = parameter("rad", "phase φ", 0.0)

    def signal(self) -> SignalModel:
        return Sine(amplitude=radians(self.angle), period=self.period, phase=self.phase)


class SteadyTurn(LikeDisplacement):
    """A rotation at constant angular velocity ω: angle θ = ω t."""

    kind: Literal["steady"] = "steady"
    angular_velocity: float = parameter("rad/s", 'angular velocity ω, in rad/s or a text such as "60 rpm"')

    def signal(self) -> SignalModel:
        return Steady(velocity=self.angular_velocity)


class TableTurn(OverTime, TurnModel):
    """A table of time [s] and angle in degrees: monotone cubic interpolation, constant before the first and after the last
    row.

    The angle is relative to that at t = 0.
    """

    kind: Literal["table"] = "table"
    path: InputFile = parameter("", "CSV file with the columns time [s] and angle [deg]; a header row is allowed")

    def rows(self) -> np.ndarray:
        rows = read_rows(self.path, "angle [deg]")
        return np.column_stack([rows[:, 0], np.radians(rows[:, 1])])


def checked_displacement(signal: SignalModel | TurnModel, where: str) -> Displacement:
    """Return the displacement [m] or angle [rad] of a signal as a function of time [s]; the function raises RunStopped if a
    value is not finite. where: name of the signal in messages."""
    what = _named(signal, where)
    with failing_as(lambda why: RunStopped(f"{what} fails in `function`: {why}"), signal.function):
        function = signal.function()

    def displacement(time: float) -> float:
        with failing_as(lambda why: RunStopped(f"{what} fails at t = {time:g} s: {why}"), function):
            value = float(function(time))
        if not isfinite(value):
            given = f"{value} {_unit(signal)} at t = {time:g} s"
            raise RunStopped(f"{what} returns {given}; correct its `function`, see {home_of(signal.function)}")
        return value

    return displacement


def displacement_fault(signal: SignalModel | TurnModel, where: str) -> str:
    """Return a text that describes what is wrong with a signal (displacement or angle as a function of time) at t = 0, or
    an empty text. A signal is invalid if it raises an error, or if its value or top speed is not finite. where: name of the
    signal in the text."""
    try:
        checked_displacement(signal, where)(0.0)
        with failing_as(lambda why: RunStopped(f"{_named(signal, where)} fails in `top_speed`: {why}"), signal.top_speed):
            speed = float(signal.top_speed())
    except RunStopped as error:
        return str(error)
    if isfinite(speed) and speed >= 0.0:
        return ""
    has = f"{_named(signal, where)} has the top speed {speed} {_unit(signal)}/s"
    return f"{has}; correct its `top_speed`, see {home_of(signal.top_speed)}"


def _named(signal: SignalModel | TurnModel, where: str) -> str:
    what = "rotation" if isinstance(signal, TurnModel) else "signal"
    return f'the {what} of kind "{signal.kind}" of {where}'


def _unit(signal: SignalModel | TurnModel) -> str:
    return "rad" if isinstance(signal, TurnModel) else "m"
