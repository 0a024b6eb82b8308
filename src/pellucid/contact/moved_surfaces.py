"""Work of contact forces on surfaces that nodes of the grid move, along the velocities of the surfaces and of the nodes."""

from collections.abc import Collection, Iterable, Mapping, Sequence
from typing import Protocol

import numpy as np

from pellucid.grid.velocity_field import VelocityField
from pellucid.jit import kernel
from pellucid.state import of_owner, with_owner


class MovedByNodes(Protocol):
    """A contact surface that grid nodes move. The surface of a solid moves with the nodal velocities that strain its points,
    the points of a fluid at a wall with those that move them."""

    velocity: np.ndarray

    def power(self, force: np.ndarray, mean: bool) -> float:
        """Return the power [W] of forces on the points of the surface [N], shape (m, 3), along the mean velocities of the nodes
        if `mean` is True, else along the velocities with which they move the surface."""


class MovedSurfaces:
    """Surfaces that nodes move: the forces on them in a step, and the account of the work of these forces.

    Attributes
    ----------
    lag_work : float
        Work of the forces as the nodes count it, minus their work along the velocities with which the surfaces move [J]:
        Δt F·v̄ - Δt/2 F·(u + u') + D, with the mean velocity v̄ of the nodes, the velocities u, u' of the surface in the last
        and in this step, and the `drag_work` D. The differences are due to the transfers between points and nodes and to
        drags; D takes the part of drags out again. See `pellucid.bodies.transfer_loss`.
    drag_work : float
        Work of the forces along the velocities that drags remove from the nodes at the start of a step [J]. It is zero if
        surfaces move first: it then remains in `lag_work`.
    """

    def __init__(self, after: Sequence[MovedByNodes], first: Sequence[MovedByNodes]) -> None:
        """after: surfaces that nodes move after the forces of a step; first: surfaces that nodes move before them (USF)."""
        self._moved_after = {id(surface): surface for surface in after}
        self._moved_first = {id(surface): surface for surface in first}
        self._forces: dict[int, np.ndarray] = {}  # on the points of these surfaces in this step [N], shape (m, 3) each
        self._counted, self._ahead, self._counted_first = 0.0, 0.0, 0.0  # powers of these forces, see `lag_work` [W]
        self.lag_work, self.drag_work = 0.0, 0.0

    def begin(self, last: float) -> None:
        """Begin the account of a step after a step of length `last` [s]; the velocities with which surfaces moved after that
        step are known only now."""
        self.lag_work = 0.5 * last * (self._counted_first - self._power(self._moved_first, mean=None))
        self._forces.clear()

    def record_forces(self, surface: object, forces: np.ndarray) -> None:
        """Take the forces on the points of a surface in this step [N], shape (m, 3), if nodes move it."""
        if id(surface) in self._moved_after or id(surface) in self._moved_first:
            self._forces[id(surface)] = forces

    def count_along_surfaces(self) -> None:
        """Compute the powers along the velocities of the surfaces, after all forces are known."""
        self._counted = -self._power(self._moved_after, mean=None)
        self._counted_first = -self._power(self._moved_first, mean=None)

    def count_along_nodes(self) -> None:
        """Compute the powers along the mean velocities of the nodes and along the velocities with which nodes will move the
        surfaces, which are final before the stresses are updated."""
        if self._forces:
            self._counted += 2.0 * self._power(self._moved_after, mean=True)
            self._counted_first += 2.0 * self._power(self._moved_first, mean=True)
            self._ahead = self._power(self._moved_after, mean=False)

    def end(self, dt: float, row: int, fields: Collection[VelocityField]) -> None:
        """Complete the works at the end of a step dt [s]. row: index, in the loads of the velocity fields, of the forces
        between surfaces on their nodes."""
        self.drag_work = 0.0
        if self._forces:
            if not self._moved_first:  # else it is part of the lag
                self.drag_work = sum(field.drag_work_of_load(row, dt) for field in fields)
            self.lag_work += 0.5 * dt * (self._counted - self._ahead) + self.drag_work

    def _power(self, moved: Mapping[int, MovedByNodes], mean: bool | None) -> float:
        """Return the power of the forces on surfaces `moved` [W]: along the mean velocities of the nodes if `mean` is True,
        along the velocities with which nodes move surfaces if it is False, and along those of the surfaces if it is None."""
        total = 0.0
        for key, surface in moved.items():
            if (force := self._forces.get(key)) is not None:
                total += _power_along(force, surface.velocity) if mean is None else surface.power(force, mean)
        return total

    # checkpoints

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the forces of the last step on surfaces that move first, by name."""
        known = ((i, self._forces[key]) for i, key in enumerate(self._moved_first) if key in self._forces)
        return _joined(with_owner(f"exerted{i}", {"force": force}) for i, force in known)

    def state_number(self) -> float:
        """Return the power of these forces that the next step needs [W]."""
        return self._counted_first

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the forces from `state_arrays`, bit for bit."""
        for i, key in enumerate(self._moved_first):
            if own := of_owner(f"exerted{i}", arrays):
                self._forces[key] = own["force"]

    def restore_number(self, counted: float) -> None:
        """Restore the power from `state_number`."""
        self._counted_first = counted


def _joined(several: Iterable[Mapping[str, np.ndarray]]) -> dict[str, np.ndarray]:
    return {name: array for arrays in several for name, array in arrays.items()}


@kernel()
def _power_along(force, velocity):
    """Return the power [W] of forces along velocities, shape (m, 3) each."""
    total = 0.0
    for p in range(len(force)):
        total += force[p, 0] * velocity[p, 0] + force[p, 1] * velocity[p, 1] + force[p, 2] * velocity[p, 2]
    return total
