"""Signals: prescribed displacements and rotations as functions of time.

This module lists the kinds that a case can name.
"""

from typing import Annotated

from pellucid.conditions.signals.displacements import Ramp, SignalModel, Sine, Steady, Table
from pellucid.conditions.signals.turns import RampTurn, SineTurn, SteadyTurn, TableTurn, TurnModel
from pellucid.model import Model, parameter
from pellucid.registry import Family, OneOf

SIGNALS = Family("signal", SignalModel)
Signal = Annotated[SignalModel, OneOf(SIGNALS)]

TURNS = Family("rotation", TurnModel)
Turn = Annotated[TurnModel, OneOf(TURNS)]

SIGNALS.add(Sine)
SIGNALS.add(Ramp)
SIGNALS.add(Steady)
SIGNALS.add(Table)

TURNS.add(SineTurn)
TURNS.add(RampTurn)
TURNS.add(SteadyTurn)
TURNS.add(TableTurn)


class AlongAxes(Model):
    """Displacements along the axes; each is optional."""

    x: Signal | None = parameter("", "displacement along x as a function of time", None)
    y: Signal | None = parameter("", "displacement along y as a function of time", None)
    z: Signal | None = parameter("", "displacement along z as a function of time", None)
