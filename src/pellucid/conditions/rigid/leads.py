"""Prescribed displacements and rotations of a rigid body in a run."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from pellucid.conditions.signals.contract import Displacement

if TYPE_CHECKING:
    from pellucid.conditions.prescribed_motion import Motion


class Leads:
    """Prescribed motions of one rigid body, by component: 0 to 2 are displacements along the axes, 3 to 5 rotations about
    the axes.

    motions: data models; along, about: axes along and about which the body can move. Attribute `led`: mask of the
    prescribed components, shape (6,).
    """

    def __init__(self, motions: "Sequence[Motion]", along: Sequence[int], about: Sequence[int]) -> None:
        self._names = [motion.name for motion in motions]
        self._functions: dict[int, Displacement] = {}
        self._owners = np.zeros((len(motions), 6), bool)
        for owner, motion in enumerate(motions):
            moves = {axis: function for axis, function in motion.functions().items() if axis in along}
            turns = {3 + axis: function for axis, function in motion.turn_functions().items() if axis in about}
            self._functions |= moves | turns
            self._owners[owner, [*moves, *turns]] = True
        self.led = np.asarray(self._owners.any(axis=0))
        self.is_whole = bool(self.led[[*along, *(3 + axis for axis in about)]].all())
        """True if all components of the motion are prescribed."""
        self.top_speed = max((motion.top_speed() for motion in motions), default=0.0)
        self.top_turn = max((motion.top_turn() for motion in motions), default=0.0)
        self.rates, self.reached = np.zeros(6), np.zeros(6)
        """Velocities over the step [m/s, rad/s], and displacements and angles at its end [m, rad]; 0 for free components."""

    def begin(self, time: float, dt: float) -> None:
        """Set the mean velocities over a step dt [s] from `time` [s], so that the body ends at the prescribed displacements
        and angles; 0 if dt = 0."""
        for number, function in self._functions.items():
            reached = function(time + dt)
            self.reached[number] = reached
            self.rates[number] = (reached - function(time)) / dt if dt > 0.0 else 0.0

    def shares(self, impulse: np.ndarray) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
        """Divide the impulses of all components, shape (6,) [N s, N m s], among the motions that prescribe these components;
        return the impulses and the angular impulses of each motion by name, shape (3,) each."""
        given = np.where(self._owners, impulse, 0.0)
        along = dict(zip(self._names, given[:, :3], strict=True))
        return along, dict(zip(self._names, given[:, 3:], strict=True))
