"""Contacts of surfaces with each other and with walls, as a simulation handles them: the base class."""

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Protocol

import numpy as np

from pellucid.contact.contact_energy import Held
from pellucid.contact.contact_surface import ContactSurface
from pellucid.contact.dead_stop import DeadStop
from pellucid.contact.images import Described
from pellucid.contact.overlap import Overlap, StartOverlap
from pellucid.contact.steady_contact import ContactLead

if TYPE_CHECKING:
    from pellucid.contact.contact_side import GivenBefore


class ContactLaw(Protocol):
    """Energy that a contact stores, and dampers by which it stops rigid bodies."""

    held: Held
    """Energy of the overlaps as the last step began."""
    is_steady: bool
    """Whether friction follows from what points moved since the last equilibrium."""
    lent: float
    """Energy that the overlaps got in this step as leads changed [J]."""
    lost: float
    """See `OverlapLaw`."""

    @property
    def stop(self) -> DeadStop | None:
        """Return the stop of rigid bodies; None of bodies that deform."""

    def separate(self, last: float, before: float = 0.0) -> None:
        """End the contact: there is no overlap. last: length of the previous step [s]; before: see `OverlapLaw`."""

    def settle(self, overlaps: Sequence[Overlap], dt: float, last: float) -> None:
        """Compute the contact forces on flat-sided rigid bodies first, so that other contacts of these bodies can include
        them."""

    def reach_equilibrium(self) -> None:
        """Continue from the equilibrium that was found."""


class Touch(ABC):
    """A body that touches another, or a wall. impulse: on the first surface over this step [N s]."""

    def __init__(self, surfaces: Sequence[ContactSurface], law: ContactLaw, name: str | None) -> None:
        self.surfaces, self.name = surfaces, name
        self.law: ContactLaw = law
        self.impulse = np.zeros(3)
        self.step = 0.0
        """Length of the step, or of the one before if that was longer [s]."""
        self.before = 0.0
        """Power of the dampers and friction of the last step along the velocities of now [W]."""

    is_last = False
    """Whether it pushes after all others, with their forces known to the bodies."""

    @property
    def between(self) -> tuple[str, ...]:
        """Names of both bodies, for messages."""
        return tuple(f"body {surface.body}" for surface in self.surfaces)

    @property
    def distance(self) -> float:
        """Distance between the points of both at which contact acts [m]."""
        return sum(float(np.max(surface.half_width, initial=0.0)) for surface in self.surfaces)

    def begin(self, time: float, rate: float) -> None:  # noqa: B027
        """Prepare a step that starts at a time of the loads [s]; rate: rate of this time relative to the time of the steps."""

    def follow(self, last: float) -> None:  # noqa: B027
        """Follow the motion of the surfaces over the step before, of a length `last` [s]."""

    @abstractmethod
    def find(self, described: dict[int, Described]) -> bool:
        """Find the overlap; whether there is one. described: the points of surfaces, by identity."""

    @abstractmethod
    def way(self) -> np.ndarray:
        """The unit vector along which the overlap found pushes, (3,), either way."""

    @abstractmethod
    def overlaps(self) -> list[Overlap]:
        """The overlaps found."""

    def start_overlaps(self) -> list[StartOverlap]:
        """Return the overlaps of the start that exert no pressure, of surfaces that have such."""
        return []

    def given_before(self) -> "list[GivenBefore]":
        """Return the forces of dampers and friction in the last step, where they are kept by points."""
        return []

    def start_depth(self) -> float:
        """Return the depth of the start that exerts no pressure as it is now [m]."""
        return max((start.depth for start in self.start_overlaps()), default=0.0)

    def begin_steady(self) -> None:
        """Find equilibria from now on; see `SurfacePairs.begin_steady`."""
        self.law.is_steady = True
        for start in self.start_overlaps():
            start.begin_steady()

    def reach_equilibrium(self) -> None:
        """Continue from the equilibrium that was found."""
        self.law.reach_equilibrium()
        for start in self.start_overlaps():
            start.reach_equilibrium()

    def leads(self) -> list[ContactLead]:
        """Return the leads by which overlaps are removed in steady states."""
        return []

    @property
    def stops_apart(self) -> bool:
        """True if each point found is stopped by itself."""
        return self.law.stop is not None and all(overlap.apart for overlap in self.overlaps())

    @abstractmethod
    def push(self, dt: float, last: float, forces: dict[int, np.ndarray], touched: dict[int, np.ndarray]) -> None:
        """Add the forces of the overlap over a step dt [s] to those of the surfaces; last: length of the step before."""

    def state_arrays(self) -> Mapping[str, np.ndarray]:
        """Return the arrays that a checkpoint stores."""
        return {}

    def restore_arrays(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the arrays of a checkpoint."""
        for name, array in self.state_arrays().items():
            array[...] = arrays[name]

    def warning(self) -> str | None:
        """Return a warning about the contact in its present state; None if there is none."""
        return None

    def external_work(self) -> float:
        """Return the work of a moving wall over this step [J]."""
        return 0.0
