"""What becomes of the work of contact between surfaces: it is stored in springs, taken by dampers and friction, or lost.

The work of a force in a step counts the mean of the velocities before and after it, (v_k + v_(k+1))/2, and the springs change
by what happens between, v_k alone. The difference goes to and fro as Δt/2 F·v (as in `pellucid.energy.budget`), so that
work + taken + stored + Δt/2 F·v stays as it is where forces follow from the overlap and its rate. What it changes by, nothing
explains: places jump over points of the other surface, areas change, steps are too long for what vibrates.
"""

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np


class Held(NamedTuple):
    """Energy of surfaces that overlap as a step begins [J]."""

    stored: float = 0.0  # in the springs of the overlap
    taken: float = 0.0  # by dampers and friction since the last step began
    pending: float = 0.0  # Δt/2 F·v of all forces


class ContactEnergy:
    """The energy of all contact between surfaces since a run began [J]."""

    def __init__(self) -> None:
        self.work = 0.0
        """That the bodies were given."""
        self.taken = 0.0
        """By dampers and friction, what the springs of the latter hold with it."""
        self.held = 0.0
        """By the overlap and half a step of its forces, as the last step began."""
        self._at_first: float | None = None
        self.unexplained = 0.0
        """What the bodies won and nothing lost, until the last step began."""

    def begin_step(self, touching: Iterable[Held]) -> None:
        """What surfaces that touch have of it as a step begins."""
        self.held = 0.0
        for stored, taken, pending in touching:
            self.held += stored + pending
            self.taken += taken
        if self._at_first is None:
            self._at_first = self.held
        self.unexplained = self.work + self.taken + self.held - self._at_first

    def add_work(self, work: float) -> None:
        """On the bodies in a step, without that of walls that move."""
        self.work += work

    def state_numbers(self) -> dict[str, float | None]:
        """What a checkpoint keeps."""
        return dict(vars(self))

    def restore(self, numbers: Mapping[str, float | None]) -> None:
        """Go on from a checkpoint."""
        vars(self).update(numbers)


def taken_by_friction(
    spring: np.ndarray,
    before: np.ndarray,
    carried: np.ndarray,
    drag: np.ndarray,
    moved: np.ndarray,
    damped: np.ndarray,
    slides: np.ndarray,
) -> float:
    """Energy that friction takes of n points that moved along the other body, shape (n, 3) [m], to where they are [J].

    spring: stiffness [N/m], (n,); before, carried: how far each was and is carried [m], drag: on each [N], (n, 3); damped: by
    the damper of what sticks [J], (n,); slides: (n,). What sticks winds up its spring, and what slides is held by the limit.
    Both count as taken: a spring gives back what it holds only as long as the point stays in contact.
    """
    wound = 0.5 * spring * (np.sum(carried * carried, axis=1) - np.sum(before * before, axis=1))
    return float(np.sum(np.where(slides, -np.einsum("ij,ij->i", drag, moved), wound + damped)))
