"""Nodal arrays for external actions on a velocity field: forces, absorbing faces and prescribed motions. Conditions request
the arrays before a run and fill them in each step."""

from typing import NamedTuple

import numpy as np

from pellucid.grid.nodal_conditions import ExternalAction, Supports
from pellucid.grid.nodal_fields import allocate, with_memory
from pellucid.grid.velocity_field import VelocityField


class DrivenNodes(NamedTuple):
    """Nodal sums over driven points, i.e. points with a prescribed motion: mass and momentum; see `ExternalAction`."""

    mass: np.ndarray  # (n, 3) mass of driven points [kg]
    momentum: np.ndarray  # (n, 3) momentum of driven points with the prescribed velocity [kg m/s]
    impulse: np.ndarray  # (n, 3) impulse of prescribed motions per driven mass over the step [m/s]


class NodalActions:
    """External forces, absorption and driven nodes of a velocity field (grid nodes shared by some bodies), and the supports
    that constrain it.

    n_loads: number of channels of external forces (entries of the energy balance for their work). Arrays that no condition
    requests have no rows, and the kernels skip them. Requested arrays are zero at first; external forces and the sums of
    driven points (points with a prescribed motion) are reset to zero before the conditions of each step.
    """

    supports: Supports
    """Constraints of the nodes, including those of thin axes."""

    def __init__(self, field: VelocityField, n_loads: int) -> None:
        self.field = field
        self._external = allocate(ExternalAction, 0, n_loads)

    def take_loads(self) -> None:
        """Allocate nodal arrays for external forces, unless they exist. In velocity fields of bodies with their own nodes
        these arrays are not needed, since such bodies store the external forces themselves."""
        if self.field.moves_points:
            self._ask("loads")

    def absorption(self) -> np.ndarray:
        """Return the rates at which absorbing faces reduce the nodal velocities [1/s], shape (nodes, 3), allocated if needed; a
        condition adds its rates to this array."""
        return self._ask("absorption").absorption

    def driven(self) -> DrivenNodes:
        """Return the arrays of nodal sums over driven points (points with a prescribed motion), allocated if needed; in each
        step a condition adds the values of its own points."""
        external = self._ask("driven_mass", "driven_momentum", "impulse")
        return DrivenNodes(external.driven_mass, external.driven_momentum, external.impulse)

    def external(self) -> ExternalAction:
        """Return all arrays of external actions as input of the momentum equation; arrays that no condition requested have no
        rows."""
        return self._external

    def _ask(self, *names: str) -> ExternalAction:
        """Allocate the fields of `ExternalAction` with these names with zeros, unless they are allocated already. Return the
        set of all fields."""
        self._external = with_memory(self._external, self.field.grid.n_nodes, *names)
        return self._external
