"""Contact on the nodes of the grid: the interface of a body, with its points, their shape functions and its surface."""

from collections.abc import Callable
from typing import Protocol, TypeGuard, runtime_checkable

import numpy as np

from pellucid.approximants import GridFunctions
from pellucid.jit.bundle import Bundle


class ContactResponse(Protocol):
    """Response of a body with its own equation of motion to impulses on the nodes of the grid."""

    def respond(self) -> None:
        """Set the velocities with which the body responds to the impulses so far on the nodes of the grid."""

    def finish(self) -> None:
        """Set these velocities on the nodes that move its points, when contact is resolved."""


class ContactBody(Protocol):
    """A body that touches others on the grid."""

    name: str

    @property
    def is_surface(self) -> bool:
        """True if the points are those of a membrane, which has two sides: a `ContactMembrane`."""

    @property
    def contact_response(self) -> ContactResponse | None:
        """Response to impulses; None where the nodes of the grid respond by their masses."""

    @property
    def n_points(self) -> int:
        """Number of points."""

    @property
    def functions(self) -> GridFunctions:
        """Shape functions between its points and the nodes of the grid."""

    @property
    def mapped(self) -> Bundle:
        """Points as arguments of kernels."""

    @property
    def n_slabs(self) -> int:
        """Number of slabs into which its points are divided."""

    def half_width(self) -> tuple[float, float, float]:
        """Return the distance of the surface from its points [m]; a negative one stands for half the edge of a point's cube.

        The edge is (volume · the second number) to the power of the third.
        """


class ContactMembrane(ContactBody, Protocol):
    """A membrane that touches others on the grid."""

    areal_density: float
    """At rest [kg/m²]."""

    def vector_areas(self) -> np.ndarray:
        """Return the share of each point in the vector area [m²], shape (n, 3), in the order in which points are stored."""


@runtime_checkable
class WarnsOfContact(Protocol):
    """A body whose surface may be too coarse for contact."""

    def contact_warning(self, nodes: np.ndarray) -> str | None:
        """Return a warning if it is too coarse where it touches others at these nodes of the grid, shape (n,), or None."""


@runtime_checkable
class WarnsOfApproach(Protocol):
    """A body that has no contact with itself, though parts of it may approach each other."""

    def approach_warning(self, is_filled: Callable[[np.ndarray, float], np.ndarray]) -> str | None:
        """Return a warning if parts of its surface have approached each other, or None.

        is_filled: returns which places [m], shape (k, 3), lie within a distance [m] of other bodies.
        """


@runtime_checkable
class TakesSecondImpulses(Protocol):
    """A body to which contact can give impulses again after its momentum was mapped to the nodes again."""

    @property
    def takes_second_impulses(self) -> bool:
        """True if it takes them now; a condition that prescribes its motion may prevent that."""

    def take_second_impulses(self, dt: float) -> float:
        """Add the second increments of its velocity field at the end of a step dt [s]; return the kinetic energy gained [J],
        0 for a body that counts its own works."""


def is_membrane(body: ContactBody) -> TypeGuard[ContactMembrane]:
    """Return True if a body is a membrane."""
    return body.is_surface
