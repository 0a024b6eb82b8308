"""Velocity field of a body with its own nodes, which has its own equation of motion."""

from collections.abc import Iterable

import numpy as np

from pellucid.energy import StepWork
from pellucid.grid.lattice import Grid
from pellucid.grid.nodal_conditions import ExternalAction, Supports
from pellucid.grid.reached import ReachedNodes
from pellucid.grid.velocity_field import VelocityField
from pellucid.jit.bundle import Bundle


class OwnNodesField(VelocityField):
    """Velocity field of one body with its own nodes; from the grid, the body receives only velocity increments by contact."""

    moves_points = False
    touches_on_nodes = True
    """True if the body may contact other fields on the nodes. Otherwise it contributes nothing to the nodes."""

    def __init__(self, name: str, grid: Grid) -> None:
        super().__init__(name, grid)
        self._reached = ReachedNodes(grid)
        self.awaiting = np.zeros(0, np.int64)
        """Sorted nodes at which contact may apply impulses in this step, shape (k,)."""

    may_be_let_go = False

    @property
    def reached(self) -> np.ndarray:
        return self._reached.node

    def set_actions(
        self,
        supports: Supports,
        external: ExternalAction,
        gravity: tuple[float, float, float],
        small_mass: float,
        flip: float,
    ) -> None:
        self._act(external)
        self._reached.constrain(supports, external)

    def share_gravity(self, share: float) -> None:
        """Do nothing: gravity acts on the body's own nodes, not on the nodes of the grid."""

    def clear(self) -> None:
        """Do nothing: the method `scatter` of this class resets the mass, momentum and forces of the grid nodes."""

    def scatter(self, n: int, mapped: Bundle, force: np.ndarray | None) -> None:
        """Map mass and momentum of the body's points, divided into n slabs, and the forces that act on them until the end of
        the step [N], shape (points, 3), to the nodes of the grid. Replaces the values of the previous step.

        mapped: bundle of `MappedPoints`; force: None if only mass and momentum are needed.
        """
        self._reached.scatter(n, mapped, force)

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {}

    def scatter_momentum(self, n: int, mapped: Bundle) -> None:
        """Map the momentum of the body's points, divided into n slabs, to the nodes again, after their velocities changed;
        mapped: bundle of `MappedPoints`."""
        self._reached.scatter_momentum(n, mapped)

    def await_impulses(self, nodes: Iterable[np.ndarray]) -> None:
        """Record the nodes at which contact may apply impulses, given as arrays of their indices; the body computes the work of
        contact itself."""
        self.awaiting = np.unique(np.concatenate([self.awaiting[:0], *nodes]))

    def advance(self, dt: float, counted: bool = False) -> None:
        self.pressed = False
        self._reached.advance(dt)
        self.external.impulse.fill(0.0)  # the work of prescribed motions is the body's, but for contact

    def add_impulses(self, impulse: np.ndarray, column: int, sign: float = 1.0, node: np.ndarray | None = None) -> np.ndarray:
        """Raise ValueError: conditions can apply impulses only to velocity fields whose nodes move points."""
        raise ValueError(f"the velocity field {self.name} does not move its body, which has nodes of its own")

    def works(self, dt: float) -> StepWork | None:
        """Return None: a body with its own nodes computes its works itself."""
        return None

    def project(self, dt: float | None = None, counted: bool = False) -> None:
        self._reached.project()
