"""Interface of a body for dynamic relaxation to steady states."""

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

SLOWER_LOADS = "increase steady.load_steps or steady.loading, or decrease steady.courant"
"""Remedy if loads grow too fast for a relaxation."""


class Springs(NamedTuple):
    """Internal forces and inertia of nodes, from which their stiffness is estimated."""

    position: np.ndarray  # (n, 3) positions of the nodes [m]
    force: np.ndarray  # (n, 3) internal forces at these positions [N]
    inertia: np.ndarray  # (n,) mass of the nodes in the relaxation [kg]
    free: np.ndarray  # (n, 3) mask of the directions that are not prescribed
    contact: tuple[np.ndarray, np.ndarray] | None = None  # positions at the start of the step [m] and contact forces there [N]

    def of_forces(self) -> tuple[np.ndarray, ...]:
        """Return arrays of positions and of internal forces; contact forces follow with their positions, if there are any."""
        return (self.position, self.force, *(self.contact or ()))


@runtime_checkable
class Relaxable(Protocol):
    """A body that can be relaxed to equilibrium."""

    def begin_relaxing(self, scaled: bool) -> None:
        """Prepare for a relaxation; scaled: scale the inertia so that all nodes have the same stable step."""

    def relax(self, keep: float, gain: float, load_rate: float, gravity_share: float) -> None:
        """Over the coming step, multiply the velocity by `keep`, and the velocity increment (acceleration times dt) by `gain`.

        load_rate: simulated time per step time, which scales the rate of the loads; gravity_share: fraction of gravity that
        acts.
        """

    def springs(self) -> Springs:
        """Return the internal forces of the last step, and the positions at which they were computed."""

    def unbalanced(self) -> tuple[float, float]:
        """Return two norms of the nodal forces without constraint forces [N]: of their components along free directions,
        which vanish in equilibrium, and of all components."""
