"""Loads on surfaces that evaluate these themselves, at the instants that they need within a step."""

from collections.abc import Callable

import numpy as np

from pellucid.parts.active_condition import ActiveCondition, AtEachStep
from pellucid.parts.annotations import Assembly
from pellucid.parts.capabilities import TakesTractions
from pellucid.parts.surface_load import SurfacePoints

TractionInTime = Callable[[SurfacePoints, float], np.ndarray]
"""Force on unit of present area [Pa], shape (..., 3), at points and a time [s]."""


def surface_load(traction: TractionInTime, body: str, channel: str, assembly: Assembly, label: str) -> ActiveCondition:
    """A load on the surface of a body that is built; channel: of its work; label: what users know it by."""
    film, column = assembly.bodies[body].offers(TakesTractions), assembly.load_column(body, channel)
    return AtEachStep(lambda time: film.add_traction(lambda points, after: traction(points, time + after), column, label))
