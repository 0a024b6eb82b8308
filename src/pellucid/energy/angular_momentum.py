"""The balance of angular momentum of a run on whose bodies nothing acts from outside."""

from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple, Protocol

import numpy as np


class AngularMomentum(NamedTuple):
    """Angular momentum about a place, and its size."""

    vector: np.ndarray  # (3,) Σ m r × v, with that of the points about themselves [N m s]
    size: float  # Σ m |r| |v| [N m s]


class Turning(Protocol):
    """Interface of a body for the balance."""

    def angular_momentum(self, about: np.ndarray) -> AngularMomentum: ...
    def stored_field(self, name: str) -> np.ndarray: ...


class AngularBalance:
    """Angular momentum of all bodies about their common centre at the start.

    axes: about which they can turn. The error is relative to the largest Σ m |r| |v| that was seen.
    """

    def __init__(self, bodies: Sequence[Turning], axes: Sequence[int]) -> None:
        mass, moment = 0.0, np.zeros(3)
        for body in bodies:
            m = body.stored_field("mass")
            mass, moment = mass + float(np.sum(m)), moment + np.sum(m[:, None] * body.stored_field("position"), axis=0)
        self._axes, self._about = list(axes), moment / mass if mass > 0.0 else moment
        self._initial, self._scale = self._sum(bodies)

    def error(self, bodies: Sequence[Turning]) -> float:
        """Change of the angular momentum since the start, relative to the largest Σ m |r| |v|; 0 where nothing moves."""
        now, size = self._sum(bodies)
        scale = max(self._scale, size)
        return float(np.abs(now - self._initial)[self._axes].max(initial=0.0) / scale) if scale > 0.0 else 0.0

    def observe(self, bodies: Sequence[Turning]) -> float:
        """Update the largest Σ m |r| |v| with the present state, and return the error."""
        self._scale = max(self._scale, self._sum(bodies)[1])
        return self.error(bodies)

    def _sum(self, bodies: Sequence[Turning]) -> tuple[np.ndarray, float]:
        of_bodies = [body.angular_momentum(self._about) for body in bodies]
        return np.sum([one.vector for one in of_bodies], axis=0), sum(one.size for one in of_bodies)

    def state_numbers(self) -> dict[str, object]:
        """Numbers for a checkpoint."""
        return {"about": self._about.tolist(), "initial": self._initial.tolist(), "scale": self._scale}

    def restore(self, numbers: Mapping[str, Any]) -> None:
        """Go on from a checkpoint."""
        self._about, self._initial = np.array(numbers["about"]), np.array(numbers["initial"])
        self._scale = float(numbers["scale"])
