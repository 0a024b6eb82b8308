"""The two families of bodies: bodies whose unknowns are on the grid, and bodies with their own nodes.

Bodies **on the grid** have points, sorted by their grid nodes, and share a velocity field with others: the scheme calls the
stages of their step one by one (`GridBody`). Bodies with **their own nodes** keep the order of their mesh and solve their own
equation of motion, explicitly or implicitly, optionally in sub-steps (`NodalBody`); they use the grid only to find contact.
"""

from abc import abstractmethod
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from pellucid.energy import StepWork
from pellucid.grid.point_storage import PointStorage
from pellucid.parts.body import Body


class TransferLoss(NamedTuple):
    """Kinetic energy [J] of a body lost by the transfers between points and grid in a step: total and parts; see
    `pellucid.grid.transfer_heat`."""

    total: float = 0.0  # whole loss
    lumping: float = 0.0
    """Part of the loss due to the lumped mass matrix."""
    kept: float = 0.0
    """Part of the loss that points store as internal energy."""


class GridBody(Body):
    """A body whose unknowns are on the grid: material points that move with the grid nodes of a velocity field."""

    storage: PointStorage
    """Arrays of the points, sorted by grid nodes and distributed among processes."""
    transfer_loss = TransferLoss()
    """Kinetic energy that transfers between points and grid lost in this step."""
    keeps_heat = False
    """True if points of the body store the kinetic energy lost by transfers and internal forces as heat: the body then
    implements `KeepsHeat`."""
    even_settings: Callable[[], str] = str
    """Function that returns the settings of the case, as text, that would keep the densities of the points of a liquid even;
    an empty text if there are none."""

    @property
    def keeps_even(self) -> bool:
        """True if density and spacing of the points are corrected, see `pellucid.grid.even_points`."""
        return False

    def fluid_volume(self) -> float:
        """Return the volume of the body's points [m³] if it is a fluid, else 0."""
        return 0.0

    def liquid_volume(self) -> float:
        """Return the volume of the body at its density at the start [m³] if it is a liquid, else 0."""
        return 0.0

    @abstractmethod
    def particle_to_grid(self, inertia: bool, force: bool) -> None:
        """Map mass and momentum (if `inertia`) and internal forces (if `force`) of the points to the grid nodes (P2G)."""

    def grid_to_particle(self, dt: float, remap: bool) -> None:
        """Update the velocities of the points (G2P) over a step dt [s]; if `remap`, map their momentum to the nodes again."""
        self.begin_grid_to_particle(dt, remap)
        self.end_grid_to_particle(remap)

    @abstractmethod
    def begin_grid_to_particle(self, dt: float, remap: bool) -> None:
        """Run the loops over points of `grid_to_particle` over a step dt [s] in the joint parallel region of all bodies,
        see `pellucid.jit.loops`; remap: True to map the momentum of the points to the nodes again."""

    @abstractmethod
    def end_grid_to_particle(self, remap: bool) -> None:
        """Complete `grid_to_particle` after the joint parallel region, e.g. apply constraints and add up the sums over
        points; remap: True if momentum was mapped to the nodes again."""

    def update_stress(self, dt: float, move: bool) -> None:
        """Update velocity gradients, volumes and stresses over a step dt [s]; if `move`, also positions."""
        self.begin_stress(dt, move)
        self.end_stress(dt, move)

    @abstractmethod
    def begin_stress(self, dt: float, move: bool) -> None:
        """Run the loops over points of `update_stress` over a step dt [s] in the joint parallel region of all bodies, see
        `pellucid.jit.loops`; move: True to move the points as well."""

    @abstractmethod
    def end_stress(self, dt: float, move: bool) -> None:
        """Complete `update_stress` after the joint parallel region, e.g. apply constraints and add up the sums over points.
        dt: step [s]; move: True if the points were moved as well."""

    def move_surface(self, dt: float) -> None:
        """Move the contact surface of the body over a step dt [s] with the velocities that strain the points, where these are
        strained before the forces (USF)."""

    @abstractmethod
    def update_positions(self, dt: float) -> None:
        """Update the positions of the points over a step dt [s], without velocity gradients and stresses."""

    def work(self) -> StepWork | None:
        """Return the works that the body itself computes in this step, such as heat from its internal forces; None if there are
        none."""
        return None


class NodalBody(Body):
    """A body with its own nodes and its own equation of motion."""

    def order(self) -> np.ndarray | slice:
        """Return the storage indices of all nodes in the order of the mesh, as a slice: nodes are stored in this order."""
        return slice(None)

    @abstractmethod
    def predict(self, dt: float) -> None:
        """Solve the equation of motion without contact over a step dt [s].

        A body that uses the grid also maps its mass and momentum to the grid, since contact needs the momentum of the grid
        nodes at the end of the step. The body maps either the momentum at the end of the step, or its present momentum
        together with the internal and external forces and gravity.
        """

    @abstractmethod
    def correct(self, remap: bool) -> None:
        """Add the velocity increments that contact caused on the grid nodes to the velocities of the body's nodes, and
        complete the velocities of the step; if `remap`, map the momentum of the body to the grid again."""

    @abstractmethod
    def update(self, dt: float) -> None:
        """Update positions, stresses, energies and the step limit at the end of a step dt [s]."""

    @abstractmethod
    def work(self) -> StepWork:
        """Return works and impulse of the body in this step; order of the works as in `pellucid.energy.WorkLayout`."""
