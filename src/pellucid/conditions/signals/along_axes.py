"""Data model of displacements along the axes."""

from pellucid.conditions.signals import Signal
from pellucid.model import Model, parameter


class AlongAxes(Model):
    """Displacements along the axes; each is optional."""

    x: Signal | None = parameter("", "displacement along x as a function of time", None)
    y: Signal | None = parameter("", "displacement along y as a function of time", None)
    z: Signal | None = parameter("", "displacement along z as a function of time", None)
