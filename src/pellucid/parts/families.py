"""The two families of bodies: those whose unknowns live on the grid, and those with their own nodes.

Bodies **on the grid** keep points, sorted by their nodes, and share a velocity field with others: the scheme calls their verbs
one by one (`GridBody`). Bodies with **their own nodes** keep the order of their mesh and solve their own equation of motion,
explicitly or implicitly, in sub-steps if they like (`NodalBody`); they use the grid only to find contact.
"""

from abc import abstractmethod
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.energy import Left, StepWork
from pellucid.parts.body import Body, NodalSupport

if TYPE_CHECKING:
    from pellucid.grid.full_cells import Filling


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
    """Whether its points take up what transfers and internal forces take from the kinetic energy."""

    @property
    def filling(self) -> "Filling | None":
        """Itself, where it is a fluid whose pressure acts in full cells as a whole; see `pellucid.grid.full_cells`."""
        return None

    def fluid_volume(self) -> float:
        """Volume of its points where it is a fluid [m³]."""
        return 0.0

    def return_heat(self, share: float) -> None:
        """Of a body that keeps heat: give up this share of what it kept in this step."""
        raise ValueError(f"body {self.name} keeps no heat")

    def add_supports(self, supports: Sequence[NodalSupport]) -> None:
        """The nodes of the grid are constrained."""

    def add_motions(self, names: Sequence[str], numbers: np.ndarray, axes: np.ndarray) -> None:
        """The `constraint` leads the points."""

    def set_motion_velocities(self, velocity: np.ndarray) -> None:
        """The `constraint` leads the points."""

    def open_faces(self, faces: Sequence[tuple[int, int]]) -> None:
        """Let points leave through faces of the grid, each an axis and an end, 0 lower and 1 upper, which its model may refuse
        before (`why_no_outflow`)."""
        raise ValueError(f"the points of body {self.name} cannot leave it")

    def let_leave(self) -> Left | None:
        """After a step: remove the points that left through these faces; None where there are none."""
        return None

    def use_separate_force_buffer(self) -> None:
        """Add internal forces to the separate buffer of its velocity field: asked of bodies that keep heat."""
        raise ValueError(f"body {self.name} keeps no heat")

    @abstractmethod
    def sort_if_needed(self) -> None:
        """Sort the points by their nodes where one left its slab, or where that saves time."""

    @abstractmethod
    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Mass and momentum (where `inertia`) and internal forces (where `force`) to the nodes."""

    def update_velocities(self, dt: float, remap: bool) -> None:
        """Grid-to-particle: new velocities; where `remap`, their momentum back on the nodes."""
        self.begin_velocities(dt, remap)
        self.end_velocities(remap)

    @abstractmethod
    def begin_velocities(self, dt: float, remap: bool) -> None:
        """What a joint region of all bodies does of `update_velocities`; see `pellucid.jit.joint`."""

    @abstractmethod
    def end_velocities(self, remap: bool) -> None:
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

    def show_start(self, dt: float) -> None:
        """Before the first step dt [s], whose conditions are set: show the velocities at the start of what has no inertia."""
        return

    @abstractmethod
    def share_gravity(self, share: float) -> None:
        """Let a share of gravity act over this step, which the body applies itself; all of it where this is never called."""

    @abstractmethod
    def let_go(self, supports: Collection[int]) -> None:
        """Let the supports of these numbers hold none of its nodes any more, and all others theirs."""

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
