"""The interface of conditions on the interpolated field of a body with its own nodes."""

from typing import Protocol

import numpy as np


class FieldCondition(Protocol):
    """Conditions that prescribe the interpolated displacement of a body at its nodes, if this displacement differs from the
    nodal coefficients.
    """

    def impulses(self, velocity: np.ndarray, inertia: np.ndarray, rows: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the impulses that enforce the prescribed velocities [N s]: on the nodes, shape (2, n, 3), for supports and
        for motions; and the sum for each support and motion, shape (rows, 3).

        velocity: velocities of the nodes at the end of the step dt [s] without these conditions [m/s], shape (n, 3); inertia:
        nodal inertia [kg], shape (n,); rows: prescribed velocities of each support and motion [m/s], shape (rows, 3).
        """
