"""Constraints that prescribe the motion of all points of a body, and bodies whose points can be constrained."""

from abc import abstractmethod
from collections.abc import Mapping
from typing import NamedTuple, Protocol, runtime_checkable

import numpy as np

from pellucid.contact.contact_body import ContactResponse
from pellucid.geometry.shapes.rotation import Turn


class PointConstraint(Protocol):
    """Interface of a constraint that prescribes the motion of the points of a body, by a prescribed motion or as a rigid
    body: it overwrites velocities and positions that grid-to-particle (G2P) computed."""

    strains: bool
    """True if the points are strained by the grid; False for a rigid body, whose positions the constraint sets."""
    top_speed: float
    """Largest prescribed velocity along an axis [m/s]."""

    def prescribe_velocities(self) -> None:
        """Overwrite the velocities of the points with the prescribed velocities after grid-to-particle (G2P), before
        momentum and energy are summed."""

    def prescribe_positions(self) -> None:
        """Overwrite the positions of the points with the prescribed positions after the points moved."""


class RigidRates(NamedTuple):
    """Velocity field of a rigid motion over a step."""

    velocity: np.ndarray  # (3,) velocity of the centre [m/s]
    turn: np.ndarray  # (3,) angular velocity [rad/s]
    centre: np.ndarray  # (3,) position of the centre [m]


@runtime_checkable
class PrescribesWhole(Protocol):
    """Interface of a constraint that can prescribe the whole motion of a body, which is then a rigid motion."""

    def placement(self) -> Turn:
        """Return the rigid motion from the initial positions of the points to the present ones."""

    def prescribed_rates(self) -> RigidRates:
        """Return the prescribed velocities over the step, once the step has begun."""

    def set_velocities(self, moving: bool) -> None:
        """Set the velocities of the points to the prescribed ones of the step that has begun, or, if not `moving`, to 0."""

    def shares(self, impulse: np.ndarray) -> tuple[Mapping[str, np.ndarray], Mapping[str, np.ndarray]]:
        """Divide impulses and angular impulses about the centre on the body, shape (6,) [N s, N m s], among the motions that
        prescribe these components; return both by the name of the motion, shape (3,) each."""


class ToolLoads(NamedTuple):
    """Loads on a rigid body in an equilibrium."""

    forces: Mapping[int, np.ndarray]  # (3,) force at the centre of mass [N], by the column of its work in arrays of works
    stiffness: np.ndarray  # (3,) derivative of the sum of the forces with respect to a displacement against them [N/m]

    @property
    def force(self) -> np.ndarray:
        """Sum of the forces [N], shape (3,)."""
        return sum(self.forces.values(), np.zeros(3))


@runtime_checkable
class PlacedBySearch(Protocol):
    """A constraint of a rigid body whose free translations a search for equilibria finds."""

    def moves_freely(self) -> bool:
        """Return True if a component of the motion is free."""

    def seek(self) -> np.ndarray:
        """Let a search, instead of the momentum of the body, find the translations that are free; rotations that are free are
        held. Returns the mask of these axes, shape (3,)."""

    def displacement(self) -> np.ndarray:
        """Return the displacement of the centre of mass since the start [m], shape (3,)."""

    def displace(self, displacement: np.ndarray) -> None:
        """Move the body so that the centre of mass has a displacement since the start [m], shape (3,)."""

    def share_gravity(self, share: float) -> None:
        """Set the fraction of gravity that acts on the body."""

    def discard_loads(self) -> None:
        """Discard the loads on the body that conditions have added since the last step."""

    def loads(self) -> ToolLoads:
        """Return the loads on the body that conditions have added since `discard_loads`, and the weight."""

    def keep_loads(self) -> None:
        """Store the loads that conditions have added since `discard_loads`, for `apply_kept_loads`."""

    def apply_kept_loads(self) -> None:
        """Replace the loads of the coming step by those of `keep_loads`."""


class RepeatedConstraint(PointConstraint):
    """A constraint that can act a second time in a step, after contact has applied impulses a second time (after momentum was
    mapped again, MUSL)."""

    @abstractmethod
    def prescribe_velocities_again(self) -> None:
        """Set the prescribed velocities a second time; `external.impulse` of the velocity fields then contains only the second
        impulses."""


class LeadsPoints(PointConstraint):
    """A constraint that prescribes the motion of some points along some axes."""

    @abstractmethod
    def rows(self) -> np.ndarray:
        """Return 1 + the number of the motion that a point follows along each axis, 0 if free, shape (n, 3), in storage
        order."""

    @abstractmethod
    def release_nodes(self, nodes: np.ndarray) -> None:
        """Exclude grid nodes, with these indices, shape (k,), from the constraint: points with a prescribed motion no
        longer constrain them. Only the contributions of points at their present positions are excluded, so these points
        must stay at rest."""


class RigidConstraint(PointConstraint):
    """A constraint that moves the points as a rigid body: the nodes change the velocity of the whole body, not of single
    points."""

    own_energy: float
    """Kinetic energy of the rotation of the points about themselves [J]."""
    mixing: float
    """Kinetic energy that nodes lost in this step because bodies share them [J]."""

    @property
    @abstractmethod
    def own_spin(self) -> np.ndarray:
        """Angular momentum due to the rotation of the points about their own centres [N m s], shape (3,)."""


class ConstrainedPoints:
    """Base class of bodies: points whose motion a condition can prescribe by a `PointConstraint`."""

    name: str
    constraint: PointConstraint | None = None
    """The constraint that prescribes the motion of the points, or None."""
    rigid: RigidConstraint | None = None
    """The constraint of the points if it moves them as a rigid body, else None."""
    _repeated: RepeatedConstraint | None = None
    """The constraint of the points if it can act a second time in a step, else None."""
    contact_response: ContactResponse | None = None
    """Response of the points to contact impulses, if it differs from that of the nodes of the grid."""

    def constrain(self, constraint: PointConstraint, response: ContactResponse | None = None) -> None:
        """Set the constraint of the points, and their response to contact impulses if it differs from that of the grid nodes.
        Raises ValueError if they already have a constraint."""
        if self.constraint is not None:
            raise ValueError(f"the motion of the points of body {self.name} is already prescribed by another condition")
        self.constraint, self.contact_response = constraint, response
        self._repeated = constraint if isinstance(constraint, RepeatedConstraint) else None
        self.rigid = constraint if isinstance(constraint, RigidConstraint) else None

    def takes_second_impulses(self) -> bool:
        """Return True if contact can apply a second impulse in a step; False if a constraint acts only once in a step."""
        return self.constraint is None or self._repeated is not None

    def constrain_again(self) -> None:
        """Apply the constraint, if there is one, a second time in this step, after the second contact impulses."""
        if self._repeated is not None:
            self._repeated.prescribe_velocities_again()
