"""What pictures of bodies show: speed, or the load that each kind of body bears."""

import numpy as np

from pellucid.results.probes import scalar
from pellucid.state import FIELDS

Cloud = dict[str, np.ndarray]
"""The fields of the points of a body at an instant."""


def meaning(scene: list[Cloud], quantity: str) -> tuple[str, str]:
    """Name and unit of a quantity, "speed" or "load", in a scene of bodies."""
    if quantity == "speed":
        return "speed", FIELDS["velocity"].unit
    kinds = dict.fromkeys("pressure" if _is_fluid(cloud) else "von Mises stress" for cloud in scene)
    return " or ".join(kinds), FIELDS["stress"].unit


def values_of(cloud: Cloud, quantity: str) -> np.ndarray:
    """The quantity of every point, shape (n,): of fluids the pressure, of solids von Mises' equivalent stress is the load."""
    if quantity == "speed":
        return scalar(cloud["velocity"])
    return cloud["pressure"] if _is_fluid(cloud) else scalar(cloud["stress"])


def _is_fluid(cloud: Cloud) -> bool:
    return "internal_energy" in cloud


def limits(values: list[list[np.ndarray]]) -> tuple[float, float]:
    """Common limits of the colours; a few extreme points do not wash out the rest."""
    everything = np.concatenate([part for scene in values for part in scene])
    everything = everything[np.isfinite(everything)]
    if not everything.size:
        return 0.0, 1.0
    low, high = (float(value) for value in np.percentile(everything, (0.5, 99.5)))
    return (low, high) if high > low else (low - 0.5, low + 0.5)
