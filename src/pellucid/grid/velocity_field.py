"""The grid as one set of bodies sees it."""

from collections.abc import Sequence
from typing import Any

from pellucid.grid.lattice import Grid
from pellucid.grid.momentum import ExternalAction, NodalMomentum, StepWork, Supports


class VelocityField:
    """Nodal arrays with what moves them: of the bodies that share a velocity field, or of one with nodes of its own.

    The nodes of a velocity field move as if no other were there; `pellucid.contact.pairs` says what they do to each other.
    """

    def __init__(self, field: str, grid: Grid, bodies: Sequence[Any], supports: Supports) -> None:
        self.field, self.grid, self.bodies = field, grid, bodies
        self.own_nodes = any(body.own_nodes for body in bodies)
        self._supports = supports

    def act(self, outside: ExternalAction, gravity: tuple[float, float, float], small_mass: float, flip: float) -> None:
        """Say what acts on the nodes: `outside` beside gravity [m/s²] and supports; see `NodalMomentum` for the others."""
        self.outside = outside
        self._motion = NodalMomentum(self.grid.nodes, self._supports, gravity, small_mass, flip, outside)
        for body in self.bodies:
            if body.own_nodes:
                body.gravity = gravity

    def advance(self, dt: float) -> StepWork:
        """Move the nodes, but for contact, and say what they did. What the own nodes of a body do is in its own books."""
        work = self._motion.advance(dt)
        if self.own_nodes:
            self.grid.nodes.contact.fill(0.0)
            self.outside.impulse.fill(0.0)  # what grips do to such nodes is in the body's books too, but for contact
        return work

    def project(self) -> None:
        """Nodal velocities of the momentum mapped last."""
        self._motion.project()


class VelocityFields(list[VelocityField]):
    """All velocity_fields of a simulation."""

    def clear_inertia(self) -> None:
        """Forget mass and momentum."""
        for velocity_field in self:
            velocity_field.grid.clear_inertia()

    def clear_momentum(self) -> None:
        """Forget momentum alone, before it is mapped again."""
        for velocity_field in self:
            velocity_field.grid.clear_momentum()

    def clear_force(self) -> None:
        """Forget internal forces."""
        for velocity_field in self:
            velocity_field.grid.clear_force()
