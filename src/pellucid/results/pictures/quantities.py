"""What pictures of bodies show: speed, of steady states the displacement, or the load that each kind of body bears."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pellucid.bodies.models import BODIES
from pellucid.results.pictures.style import DIVERGING, SEQUENTIAL, Extend
from pellucid.results.storage.probes import scalar
from pellucid.results.storage.stored_case import StoredBody
from pellucid.state import FIELDS

Fields = dict[str, np.ndarray]
"""The fields of a body at an instant, by name."""


BOTH_SIGNS = 0.2
"""Where the smaller of the largest values of either sign is this part of the larger, zero has a colour of its own."""


class Limits(NamedTuple):
    """Values at the ends of the colours, and at which of them values go on beyond."""

    low: float
    high: float
    extend: Extend

    @property
    def palette(self) -> str:
        """The colours: those of two signs where zero lies in the middle."""
        return DIVERGING if self.low == -self.high else SEQUENTIAL


def is_still(body: StoredBody) -> bool:
    """Whether it is of a kind that does not move."""
    return body.kind in BODIES.entries and not BODIES.entries[body.kind].moves


def _pictured(body: StoredBody) -> tuple[str, str] | None:
    """The field that its kind declares for what it bears, and what that is called."""
    return BODIES.entries[body.kind].pictured if body.kind in BODIES.entries else None


def is_film(body: StoredBody) -> bool:
    """Whether it is a fluid film, which has no thickness and no stress but in its surface."""
    return body.kind == "fluid-film"


def meaning(bodies: Sequence[StoredBody], quantity: str) -> tuple[str, str]:
    """Name and unit of a quantity, "speed", "displacement" or "load", of several bodies."""
    if quantity != "load":
        return quantity, FIELDS["velocity" if quantity == "speed" else "position"].unit
    own = {_pictured(body) for body in bodies}
    if len(own) == 1 and (found := own.pop()) is not None:
        return found[1], FIELDS[found[0]].unit
    kinds = dict.fromkeys("pressure" if body.equation_of_state else "von Mises stress" for body in bodies)
    return " or ".join(kinds), FIELDS["stress"].unit


def values_of(body: StoredBody, fields: Fields, quantity: str, start: np.ndarray) -> np.ndarray:
    """The quantity of every point, shape (n,). The load is the field that its kind declares, else the pressure of a body with
    an equation of state, of others von Mises' equivalent stress. start: first positions [m], shape (n, 3), from which
    displacements count."""
    if quantity == "speed":
        return scalar(fields["velocity"])
    if quantity == "displacement":
        return scalar(fields["position"] - start)
    if (found := _pictured(body)) is not None:
        return scalar(fields[found[0]])
    return fields["pressure"] if body.equation_of_state else scalar(fields["stress"])


def limits(values: list[np.ndarray]) -> Limits:
    """Common limits of the colours; a few extreme points do not wash out the rest. Only negative values go below 0; where there
    are large ones of both signs, zero is in the middle."""
    everything = np.concatenate(values)
    everything = everything[np.isfinite(everything)]
    if not everything.size:
        return Limits(0.0, 1.0, "neither")
    least, most = float(everything.min()), float(everything.max())
    low, high = (float(value) for value in np.percentile(everything, (0.5, 99.5)))
    if high <= low:  # nearly all values are the same
        if least >= 0.0:
            low, high = 0.0, high or 1.0
        elif low != 0.0:
            low, high = low - 0.5 * abs(low), low + 0.5 * abs(low)
        else:
            low, high = least, most
    if min(-low, high) > BOTH_SIGNS * max(-low, high):
        low, high = -max(-low, high), max(-low, high)
    below, above = least < low, most > high
    return Limits(low, high, "both" if below and above else "min" if below else "max" if above else "neither")
