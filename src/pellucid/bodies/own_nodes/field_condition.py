"""The interface of conditions on the field that a body's own nodes span."""

from typing import Protocol

import numpy as np


class FieldCondition(Protocol):
    """Conditions on the field that the nodes span, where it does not take the nodes' values."""

    def impulses(self, velocity: np.ndarray, inertia: np.ndarray, rows: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the impulses that enforce the prescribed values [N s]: by node, shape (2, n, 3), first of supports, then
        of motions; and by row of these.

        velocity: of free nodes at the end of the step dt [s], shape (n, 3) [m/s]; inertia: shape (n,) [kg]; rows:
        prescribed velocities, shape (rows, 3) [m/s].
        """
