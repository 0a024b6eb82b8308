"""What the loads and signals of users return, checked; what they raise, told with their file and line."""

from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from pellucid.errors import RunStopped
from pellucid.users_code import WrongArray, as_array, failing_as, home_of

if TYPE_CHECKING:
    from pellucid.conditions.load import Load, PointsView
    from pellucid.conditions.signals import Displacement, SignalModel


def checked_forces(load: "Load", points: "PointsView", time: float) -> np.ndarray:
    """The forces of a load [N], shape (n, 3), if they are what they must be. Raises RunStopped."""

    def stopped(why: str) -> RunStopped:
        return RunStopped(f'the load of kind "{load.kind}" on body {load.body} {why}', body=load.body)

    with failing_as(lambda why: stopped(f"fails in `forces` at t = {time:g} s: {why}"), load.forces):
        found = load.forces(points, time)
    try:
        forces = as_array(found, (len(points.mass), 3), load.forces)
    except WrongArray as error:
        raise stopped(f"gives no forces: `forces` {error}") from None
    if not np.isfinite(forces).all():
        point = int(np.flatnonzero(~np.isfinite(forces).all(axis=1))[0])
        place = ", ".join(f"{value:.6g}" for value in points.position[point])
        text = f"gives the force {forces[point]} N at t = {time:g} s on the point at ({place}) m"
        raise stopped(f"{text}; mend its `forces`, see {home_of(load.forces)}")
    return np.ascontiguousarray(forces)


def checked_displacement(signal: "SignalModel", where: str) -> "Displacement":
    """The function of a signal; a value that is no finite number stops the run with RunStopped. where: its key."""
    what = _named(signal, where)
    with failing_as(lambda why: RunStopped(f"{what} fails in `function`: {why}"), signal.function):
        function = signal.function()

    def displacement(time: float) -> float:
        with failing_as(lambda why: RunStopped(f"{what} fails at t = {time:g} s: {why}"), function):
            value = float(function(time))
        if not isfinite(value):
            raise RunStopped(f"{what} gives {value} m at t = {time:g} s; mend its `function`, see {home_of(signal.function)}")
        return value

    return displacement


def displacement_fault(signal: "SignalModel", where: str) -> str:
    """What is wrong with a signal at the start, or nothing: it fails, or its displacement or top speed is no finite number."""
    try:
        checked_displacement(signal, where)(0.0)
        with failing_as(lambda why: RunStopped(f"{_named(signal, where)} fails in `top_speed`: {why}"), signal.top_speed):
            speed = float(signal.top_speed())
    except RunStopped as error:
        return str(error)
    if isfinite(speed) and speed >= 0.0:
        return ""
    return f"{_named(signal, where)} has the top speed {speed} m/s; mend its `top_speed`, see {home_of(signal.top_speed)}"


def _named(signal: "SignalModel", where: str) -> str:
    return f'the signal of kind "{signal.kind}" of {where}'
