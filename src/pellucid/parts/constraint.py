"""What prescribes the motion of the points of a body as a whole, and bodies whose points follow it."""

from typing import Protocol, runtime_checkable

import numpy as np

from pellucid.contact.contact_body import ContactResponse


class PointConstraint(Protocol):
    """Prescribes the motion of points, such as a prescribed motion or rigidity: it changes what grid-to-particle gave them."""

    strains: bool
    """True if the points are strained by the grid; not where the body is rigid, and the constraint gives all positions."""
    top_speed: float
    """Largest prescribed velocity along an axis [m/s]."""

    def prescribe_velocities(self) -> None:
        """After grid-to-particle, and before their sums are taken: the velocities of the points."""

    def prescribe_positions(self) -> None:
        """After the points moved: their positions."""


@runtime_checkable
class RepeatedConstraint(PointConstraint, Protocol):
    """A constraint that can act once more in a step, after the second impulses of contact."""

    def prescribe_velocities_again(self) -> None:
        """The same, in addition, when the fields' `external.impulse` has these impulses alone."""


@runtime_checkable
class LeadsPoints(PointConstraint, Protocol):
    """A constraint that prescribes the motion of some points along some axes."""

    def rows(self) -> np.ndarray:
        """1 + the number of the motion that a point follows along each axis, 0 where it is free, shape (n, 3), in the order in
        which the points are stored."""

    def release_nodes(self, nodes: np.ndarray) -> None:
        """Leave these nodes of the grid, shape (k,), free of points that rest where they are now."""


@runtime_checkable
class RigidConstraint(PointConstraint, Protocol):
    """A constraint that moves the points as a rigid body: they take no velocity from the nodes, but it does as a whole."""

    own_energy: float
    """Kinetic energy that the points have by turning about themselves [J]."""
    mixing: float
    """Kinetic energy that nodes lost in this step as bodies share them [J]."""

    @property
    def own_spin(self) -> np.ndarray:
        """Angular momentum of the points about themselves [N m s], (3,)."""


class ConstrainedPoints:
    """Points whose motion a condition may prescribe."""

    name: str
    constraint: PointConstraint | None = None
    """What prescribes their motion, if anything."""
    rigid: RigidConstraint | None = None
    """The same, where it moves them as a rigid body."""
    _repeated: RepeatedConstraint | None = None
    """The same, where it can act once more in a step."""
    contact_response: ContactResponse | None = None
    """How they respond to the impulses of contact, where they do otherwise than the nodes of the grid."""

    def constrain(self, constraint: PointConstraint, response: ContactResponse | None = None) -> None:
        """Let a condition prescribe the motion of the points, and respond to contact where it can. Raises ValueError where
        another one does."""
        if self.constraint is not None:
            raise ValueError(f"the points of body {self.name} are led by a condition already")
        self.constraint, self.contact_response = constraint, response
        self._repeated = constraint if isinstance(constraint, RepeatedConstraint) else None
        self.rigid = constraint if isinstance(constraint, RigidConstraint) else None

    @property
    def takes_second_impulses(self) -> bool:
        """True if contact may give it impulses once more: not where the constraint, if there is one, acts once in a step."""
        return self.constraint is None or self._repeated is not None

    def constrain_again(self) -> None:
        """Let the constraint, if there is one, act once more in this step."""
        if self._repeated is not None:
            self._repeated.prescribe_velocities_again()
