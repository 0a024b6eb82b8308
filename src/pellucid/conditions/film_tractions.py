"""Loads on surfaces that evaluate these themselves, at the instants that they need within a step."""

from collections.abc import Callable

import numpy as np

from pellucid.parts.active_condition import ActiveCondition
from pellucid.parts.annotations import Assembly
from pellucid.parts.capabilities import TakesTractions
from pellucid.parts.surface_load import SurfacePoints

TractionInTime = Callable[[SurfacePoints, float], np.ndarray]
"""Force on unit of present area [Pa], shape (..., 3), at points and a time [s]."""


class ActiveSurfaceLoad(ActiveCondition):
    """A load on the surface of a body that is built; channel: of its work; label: what users know it by."""

    def __init__(self, traction: TractionInTime, body: str, channel: str, assembly: Assembly, label: str) -> None:
        self._body, self._traction, self._label = assembly.bodies[body].offers(TakesTractions), traction, label
        self._column = assembly.load_column(body, channel)

    def begin(self, time: float, dt: float) -> None:
        """What it does over the step."""
        self._body.add_traction(lambda points, after: self._traction(points, time + after), self._column, self._label)
