"""Checks of the values of user-defined functions of time (signals). Errors are reported with file and line."""

from math import isfinite

from pellucid.conditions.signals.displacements import Displacement, SignalModel
from pellucid.conditions.signals.turns import TurnModel
from pellucid.errors import RunStopped
from pellucid.users.users_code import failing_as, home_of


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
