"""The actions on the nodes of a velocity field, as conditions ask for them before a run."""

from typing import NamedTuple

import numpy as np

from pellucid.grid.momentum import ExternalAction
from pellucid.grid.nodal_fields import allocate, with_memory
from pellucid.grid.supports import Supports
from pellucid.grid.velocity_field import VelocityField


class DrivenNodes(NamedTuple):
    """Nodal sums of driven points; see `ExternalAction`."""

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
        self._external = allocate(ExternalAction, 0, n_loads)

    def take_loads(self) -> None:
        """Allocate nodal arrays for external forces of the field's bodies; bodies with their own nodes have their own."""
        if self.field.moves_points:
            self._ask("loads")

    def absorption(self) -> np.ndarray:
        """Rates at which absorbing faces take momentum [1/s], shape (n, 3), to which a condition adds its own."""
        return self._ask("absorption", "absorbed").absorption

    def driven(self) -> DrivenNodes:
        """Return the nodal sums of driven points; a condition adds its own in each step."""
        external = self._ask("driven_mass", "driven_momentum", "impulse")
        return DrivenNodes(external.driven_mass, external.driven_momentum, external.impulse)

    def external(self) -> ExternalAction:
        """Return the requested arrays for the momentum equation."""
        return self._external

    def _ask(self, *names: str) -> ExternalAction:
        """Have memory for these fields, which are zero at first."""
        self._external = with_memory(self._external, self.field.grid.n_nodes, *names)
        return self._external
