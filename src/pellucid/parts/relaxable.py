"""The interface of a body to the relaxation towards steady states."""

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

SLOWER_LOADS = "raise steady.load_steps or steady.loading, or lower steady.courant"
"""What a user can do where loads grow too fast for a relaxation."""


class Springs(NamedTuple):
    """What nodes resist with."""

    position: np.ndarray  # (n, 3) [m]
    force: np.ndarray  # (n, 3) internal forces there [N]
    inertia: np.ndarray  # (n,) [kg]
    free: np.ndarray  # (n, 3) which directions are not prescribed
    contact: tuple[np.ndarray, np.ndarray] | None = None  # positions as the step began [m] and forces of contact there [N]

    def of_forces(self) -> tuple[np.ndarray, ...]:
        """Positions and forces, those of contact last."""
        return (self.position, self.force, *(self.contact or ()))


@runtime_checkable
class Relaxable(Protocol):
    """A body that can be brought to rest in equilibrium."""

    def begin_relaxing(self, scaled: bool) -> None:
        """Get ready for a relaxation; scaled: whether inertia is to be such that all nodes allow the same step."""

    def relax(self, keep: float, gain: float, load_rate: float, gravity_share: float) -> None:
        """Over the coming step keep this share of the velocity, and gain this share of dt times the acceleration.

        load_rate: how fast the loads change, in simulated time over that of the step; gravity_share: what acts of gravity.
        """

    def springs(self) -> Springs:
        """Its internal forces of the last step, and the places where they were found."""

    def unbalanced(self) -> tuple[float, float]:
        """Norms of the forces [N] on its nodes without those of constraints: along the free directions, and of all."""
