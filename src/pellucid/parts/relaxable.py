"""Interface of a body for dynamic relaxation to steady states."""

from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

SLOWER_LOADS = "increase steady.load_steps or steady.loading, or decrease steady.courant"
"""Remedy if loads grow too fast for a relaxation."""


class Springs(NamedTuple):
    """Internal forces and masses of the nodes in a relaxation, from whose changes the stiffness is estimated."""

    position: np.ndarray  # (n, 3) positions of the nodes [m]
    force: np.ndarray  # (n, 3) internal forces at these positions [N]
    inertia: np.ndarray  # (n,) mass of the nodes in the relaxation [kg]
    free: np.ndarray  # (n, 3) mask of the directions that are not prescribed
    contact: tuple[np.ndarray, np.ndarray] | None = None  # positions at the start of the step [m] and contact forces there [N]

    def of_forces(self) -> tuple[np.ndarray, ...]:
        """Return the positions [m] and internal forces [N] of the nodes, and, if there is contact, the positions at the
        start of the step and the contact forces there, shape (n, 3) each."""
        return (self.position, self.force, *(self.contact or ()))


@runtime_checkable
class Relaxable(Protocol):
    """A body that can be brought to equilibrium by dynamic relaxation (`pellucid.simulation.steady`)."""

    def begin_relaxing(self, scaled: bool) -> None:
        """Prepare the body for a dynamic relaxation; scaled: True to scale the inertia of the nodes so that all nodes have
        the same stable step."""

    def relax(self, keep: float, gain: float, load_rate: float, gravity_share: float) -> None:
        """Set the damping for the coming step: the velocities of the nodes are multiplied by `keep`, and their velocity
        increments (acceleration times dt) by `gain`.

        load_rate: increment of the time of the loads over the length of the step; gravity_share: fraction of gravity that
        acts.
        """

    def springs(self) -> Springs:
        """Return the internal forces of the nodes in the last step [N], with the positions at which they were computed [m]
        and the masses of the nodes in the relaxation [kg], see `Springs`."""

    def unbalanced(self) -> tuple[float, float]:
        """Return two norms of the forces on the nodes, without constraint forces [N]: of their components along free
        directions, which vanish in equilibrium, and of all components."""
