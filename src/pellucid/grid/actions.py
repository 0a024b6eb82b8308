"""The actions on the nodes of a velocity field, as conditions ask for them before a run."""

from typing import NamedTuple

import numpy as np

from pellucid.grid.momentum import ExternalAction
from pellucid.grid.supports import Supports
from pellucid.grid.velocity_field import VelocityField


class DrivenNodes(NamedTuple):
    """What driven points bring to the nodes; see `ExternalAction`."""

    mass: np.ndarray  # (n, 3) of driven points [kg]
    momentum: np.ndarray  # (n, 3) of these, with the prescribed velocity [kg m/s]
    impulse: np.ndarray  # (n, 3) of prescribed motions on unit driven mass over the step [m/s]


class NodalActions:
    """External forces, absorption and driven nodes of a velocity field, and the supports that constrain it.

    What no condition asks for has arrays without rows, which the kernels skip. Those that are asked for begin at zero;
    external forces and what driven points bring are zero again before the conditions of each step.
    """

    supports: Supports
    """What constrains the nodes, thin axes included."""

    def __init__(self, field: VelocityField, n_loads: int) -> None:
        self.field = field
        self._loads, self._absorption = np.zeros((n_loads, 0, 3)), np.zeros((0, 3))
        self._driven = DrivenNodes(*(np.zeros((0, 3)) for _ in range(3)))

    def take_loads(self) -> None:
        """Let the bodies of the field take external forces; those with their own nodes keep these themselves."""
        if self.field.moves_points and not self._loads.shape[1]:
            self._loads = np.zeros((len(self._loads), self.field.grid.n_nodes, 3))

    def absorption(self) -> np.ndarray:
        """Rates at which absorbing faces take momentum [1/s], shape (n, 3), to which a condition adds its own."""
        if not len(self._absorption):
            self._absorption = np.zeros((self.field.grid.n_nodes, 3))
        return self._absorption

    def driven(self) -> DrivenNodes:
        """What driven points bring to the nodes, to which a condition adds that of its own in each step."""
        if not len(self._driven.mass):
            self._driven = DrivenNodes(*(np.zeros((self.field.grid.n_nodes, 3)) for _ in range(3)))
        return self._driven

    def external(self) -> ExternalAction:
        """All that was asked for, as the momentum equation takes it."""
        return ExternalAction(self._loads, self._absorption, np.zeros_like(self._absorption), *self._driven)
