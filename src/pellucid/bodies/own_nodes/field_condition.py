"""The interface of conditions on the interpolated field of a body with its own nodes."""

from typing import Protocol

import numpy as np


class FieldCondition(Protocol):
    """Conditions on the interpolated displacement of a body, if its values at the nodes differ from the nodal coefficients."""

    def impulses(self, velocity: np.ndarray, inertia: np.ndarray, rows: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the impulses that enforce the prescribed values [N s]: on the nodes, shape (2, n, 3), for supports and for
        motions; and the sum for each row of `rows`, shape (rows, 3).

        velocity: velocities of the nodes at the end of the step dt [s] without these conditions [m/s], shape (n, 3); inertia:
        [kg], shape (n,); rows: prescribed velocities of each support and motion [m/s], shape (rows, 3).
        """
