"""What pictures of bodies show: speed, of steady states the displacement, or the load that each kind of body bears."""

from collections.abc import Sequence
from typing import Literal, NamedTuple

import numpy as np

from pellucid.results.storage.probes import scalar
from pellucid.results.storage.stored_case import StoredBody
from pellucid.state import FIELDS

Fields = dict[str, np.ndarray]
"""The fields of a body at an instant, by name."""


class Limits(NamedTuple):
    """Values at the ends of the colours, and at which of them values go on beyond."""

    low: float
    high: float
    extend: Literal["neither", "both", "min", "max"]


def meaning(bodies: Sequence[StoredBody], quantity: str) -> tuple[str, str]:
    """Name and unit of a quantity, "speed", "displacement" or "load", of several bodies."""
    if quantity != "load":
        return quantity, FIELDS["velocity" if quantity == "speed" else "position"].unit
    kinds = dict.fromkeys("pressure" if body.equation_of_state else "von Mises stress" for body in bodies)
    return " or ".join(kinds), FIELDS["stress"].unit


def values_of(body: StoredBody, fields: Fields, quantity: str, start: np.ndarray) -> np.ndarray:
    """The quantity of every point, shape (n,). The load is the pressure of a body with an equation of state, of others von
    Mises' equivalent stress. start: first positions [m], shape (n, 3), from which displacements count."""
    if quantity == "speed":
        return scalar(fields["velocity"])
    if quantity == "displacement":
        return scalar(fields["position"] - start)
    return fields["pressure"] if body.equation_of_state else scalar(fields["stress"])


def limits(values: list[np.ndarray]) -> Limits:
    """Common limits of the colours; a few extreme points do not wash out the rest. Only negative values go below 0."""
    everything = np.concatenate(values)
    everything = everything[np.isfinite(everything)]
    if not everything.size:
        return Limits(0.0, 1.0, "neither")
    least, most = float(everything.min()), float(everything.max())
    low, high = (float(value) for value in np.percentile(everything, (0.5, 99.5)))
    if high <= low:  # nearly all values are the same
        low, high = (0.0, high or 1.0) if least >= 0.0 else (low - 0.5 * abs(low), low + 0.5 * abs(low))
    below, above = least < low, most > high
    return Limits(low, high, "both" if below and above else "min" if below else "max" if above else "neither")
