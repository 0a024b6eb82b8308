"""Forces and torques on a rigid body as a whole."""

from typing import NamedTuple

import numpy as np


class Push(NamedTuple):
    """A force at the centre of mass [N] and a torque [N m], together of shape (6,), over a step."""

    strength: np.ndarray
    column: int  # of its work
    carried: np.ndarray | None = None  # of a damper: velocity and angular velocity of what it is fixed to, shape (6,)
    heat: int = 0  # of a damper: column of what it takes

    def book(self, works: np.ndarray, dt: float, rates: np.ndarray) -> float:
        """Add its work over a step dt [s] on a body with a velocity and an angular velocity, shape (6,), to a row; the work."""
        work = dt * float(self.strength @ rates)
        if self.carried is None:
            works[self.column] += work
        else:
            given = dt * float(self.strength @ self.carried)
            works[self.column] += given
            works[self.heat] += given - work
        return work
