"""The interface of conditions on the interpolated field of a body with its own nodes."""

from typing import Protocol

import numpy as np


class FieldCondition(Protocol):
    """Conditions on the interpolated field of a body, if its values at the nodes differ from the nodal coefficients."""

    def impulses(self, velocity: np.ndarray, inertia: np.ndarray, rows: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the impulses that enforce the prescribed values [N s]: by node, shape (2, n, 3), for supports and for
        motions; and by row.

        velocity: velocities of free nodes at the end of the step dt [s], shape (n, 3) [m/s]; inertia: shape (n,) [kg];
        rows: prescribed velocities, shape (rows, 3) [m/s].
        """
