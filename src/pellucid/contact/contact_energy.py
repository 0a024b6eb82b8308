"""Energy of contact between surfaces: its work is stored in springs, taken by dampers and friction, or lost.

The work of a force in a step counts the mean of the velocities before and after it, (v_k + v_(k+1))/2, and the springs change
by the velocity between, v_k alone. The difference is the pending energy Δt/2 F·v (as in `pellucid.energy.budget`), so that
work + taken + stored + Δt/2 F·v is constant where forces follow from the overlap and its rate. Its change is the unexplained
energy: places jump over points of the other surface, areas change, or steps are too long for the vibrations.
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
    """Energy of all contact between surfaces since a run began [J].

    Attributes
    ----------
    work : float
        Work on the bodies.
    taken : float
        Energy that dampers and friction took, with that in the springs of friction.
    held : float
        Stored and pending energy as the last step began.
    unexplained : float
        Energy that the bodies gained and no contact lost, until the last step began.
    """

    def __init__(self) -> None:
        self.work = self.taken = self.held = self.unexplained = 0.0
        self._at_first: float | None = None

    def begin_step(self, touching: Iterable[Held]) -> None:
        """Sum stored, taken and pending energy at the start of a step."""
        self.held = 0.0
        for stored, taken, pending in touching:
            self.held += stored + pending
            self.taken += taken
        if self._at_first is None:
            self._at_first = self.held
        self.unexplained = self.work + self.taken + self.held - self._at_first

    def add_work(self, work: float) -> None:
        """Add the work on the bodies in a step, without that of moving walls."""
        self.work += work

    def state_numbers(self) -> dict[str, float | None]:
        """Return the state for a checkpoint."""
        return dict(vars(self))

    def restore(self, numbers: Mapping[str, float | None]) -> None:
        """Restore a checkpoint."""
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
    """Return the energy that friction takes as n points move along the other body by `moved`, shape (n, 3) [m] [J].

    spring: stiffness [N/m], (n,); before, carried: displacement of each point from where it stuck, before and now [m], drag:
    force on each [N], (n, 3); damped: energy of the damper of points that stick [J], (n,); slides: (n,). Points that stick wind
    up their spring, and the limit of friction acts on points that slide. Both count as taken: a spring returns its energy only
    as long as the point stays in contact.
    """
    wound = 0.5 * spring * (np.sum(carried * carried, axis=1) - np.sum(before * before, axis=1))
    return float(np.sum(np.where(slides, -np.einsum("ij,ij->i", drag, moved), wound + damped)))
