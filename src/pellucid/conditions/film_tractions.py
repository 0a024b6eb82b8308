"""Loads on surfaces of bodies, such as fluid films, that need the force per unit area at several times within a step."""

from collections.abc import Callable

import numpy as np

from pellucid.parts.annotations import Assembly
from pellucid.parts.capabilities import TakesTractions
from pellucid.parts.surface_load import SurfacePoints
from pellucid.step.part import AtEachStep, StepPart

TractionInTime = Callable[[SurfacePoints, float], np.ndarray]
"""Function of surface points and time [s] that returns the force per unit current area [Pa], shape (..., 3)."""


def surface_load(traction: TractionInTime, body: str, channel: str, assembly: Assembly, label: str) -> StepPart:
    """Return an active condition that applies a force per unit area [Pa], given by the function `traction` of points and
    time, to the body named `body`; channel: name of the entry of the energy balance for the work of this force; label: name
    of the load for users."""
    film, column = assembly.bodies[body].offers(TakesTractions), assembly.load_column(body, channel)
    return AtEachStep(lambda time: film.add_traction(lambda points, after: traction(points, time + after), column, label))
