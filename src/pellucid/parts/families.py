"""The two families of bodies: those whose unknowns live on the grid, and those with their own nodes.

Bodies **on the grid** keep points, sorted by their nodes, and share a velocity field with others: the scheme calls the stages
of their step one by one (`GridBody`). Bodies with **their own nodes** keep the order of their mesh and solve their own equation
of motion, explicitly or implicitly, in sub-steps if they like (`NodalBody`); they use the grid only to find contact.
"""

from abc import abstractmethod
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.energy import StepWork
from pellucid.parts.body import Body

if TYPE_CHECKING:
    from pellucid.grid.full_cells import Filling
    from pellucid.grid.implicit_viscosity import Viscous


class TransferLoss(NamedTuple):
    """Kinetic energy that the transfers of a step between points and grid lost [J]; see `pellucid.grid.transfer_heat`."""

    total: float = 0.0
    lumping: float = 0.0
    """Of it what lumping took."""
    kept: float = 0.0
    """Of it what the points took up as internal energy."""


class GridBody(Body):
    """A body whose unknowns live on the grid."""

    transfer_loss = TransferLoss()
    """Of this step."""
    keeps_heat = False
    """Whether its points take up what transfers and internal forces take from the kinetic energy: it `KeepsHeat`."""

    @property
    def filling(self) -> "Filling | None":
        """Itself, where it is a fluid whose pressure acts in full cells as a whole; see `pellucid.grid.full_cells`."""
        return None

    @property
    def viscous(self) -> "Viscous | None":
        """Itself, where it is a fluid whose viscosity is solved for on the nodes; see `pellucid.grid.implicit_viscosity`."""
        return None

    def fluid_volume(self) -> float:
        """Volume of its points where it is a fluid [m³]."""
        return 0.0

    @abstractmethod
    def sort_if_needed(self) -> None:
        """Sort the points by their nodes where one left its slab, or where that saves time."""

    @abstractmethod
    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Mass and momentum (where `inertia`) and internal forces (where `force`) to the nodes."""

    def grid_to_particle(self, dt: float, remap: bool) -> None:
        """New velocities; where `remap`, their momentum back on the nodes."""
        self.begin_grid_to_particle(dt, remap)
        self.end_grid_to_particle(remap)

    @abstractmethod
    def begin_grid_to_particle(self, dt: float, remap: bool) -> None:
        """What a joint region of all bodies does of `grid_to_particle`; see `pellucid.jit.joint`."""

    @abstractmethod
    def end_grid_to_particle(self, remap: bool) -> None:
        """The rest, where the region is done."""

    def update_stress(self, dt: float, move: bool) -> None:
        """Velocity gradients, volumes, stresses; where `move`, new positions."""
        self.begin_stress(dt, move)
        self.end_stress(dt, move)

    @abstractmethod
    def begin_stress(self, dt: float, move: bool) -> None:
        """What a joint region of all bodies does of `update_stress`."""

    @abstractmethod
    def end_stress(self, dt: float, move: bool) -> None:
        """The rest, where the region is done."""

    @abstractmethod
    def update_positions(self, dt: float) -> None:
        """New positions alone."""

    def work(self) -> StepWork | None:
        """What it counts itself of the work of this step, if anything, such as the heat that its internal forces leave."""
        return None


class NodalBody(Body):
    """A body with its own nodes and its own equation of motion."""

    def order(self) -> np.ndarray | slice:
        """Nodes keep the order of the mesh."""
        return slice(None)

    @abstractmethod
    def predict(self, dt: float) -> None:
        """Solve the equation of motion without contact over a step dt [s], and where it uses the grid, scatter what contact
        needs: mass, and the momentum that the nodes would have at the end of the step.

        That may be the trial momentum itself, or the momentum as it is and the forces that change it, internal and external
        ones and gravity.
        """

    @abstractmethod
    def correct(self, remap: bool) -> None:
        """Take the nodal velocity increments of contact, if any, and end the step with new velocities; where `remap`, their
        momentum mapped to the nodes of the grid again."""

    @abstractmethod
    def update(self, dt: float) -> None:
        """New positions, and what follows from them: stresses, energies, the bound on the step."""

    @abstractmethod
    def work(self) -> StepWork:
        """Work and impulses of this step, in the layout of `pellucid.energy`."""
