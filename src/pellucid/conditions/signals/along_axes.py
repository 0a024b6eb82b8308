"""Data model of displacements along the axes."""

from pellucid.conditions.signals import Signal
from pellucid.model import Model, parameter


class AlongAxes(Model):
    """Displacements along the axes; each is optional."""

    x: Signal | None = parameter("", "along x", None)
    y: Signal | None = parameter("", "along y", None)
    z: Signal | None = parameter("", "along z", None)
