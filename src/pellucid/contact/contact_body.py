"""What contact on the nodes of the grid asks of a body: its points, how they reach the nodes, and where its surface is."""

from typing import Protocol, TypeGuard, runtime_checkable

import numpy as np

from pellucid.approximants import GridFunctions
from pellucid.jit.bundle import Bundle


class ContactResponse(Protocol):
    """What moves the nodes that a body reaches otherwise than by their own masses."""

    def respond(self) -> None:
        """Let the nodes of the grid have the velocities with which the body responds to the impulses so far."""

    def finish(self) -> None:
        """Contact is resolved: make these velocities those of the nodes, where they move the points."""


class ContactBody(Protocol):
    """A body that touches others on the grid."""

    name: str

    @property
    def is_surface(self) -> bool:
        """Whether the points are those of a membrane, which has two sides: a `ContactMembrane`."""

    @property
    def contact_response(self) -> ContactResponse | None:
        """How it responds to impulses; None where the nodes of the grid take them by their masses."""

    @property
    def n_points(self) -> int:
        """Number of points."""

    @property
    def functions(self) -> GridFunctions:
        """Shape functions between its points and the nodes of the grid."""

    @property
    def mapped(self) -> Bundle:
        """Its points as the kernels over points take them."""

    @property
    def n_slabs(self) -> int:
        """Number of slabs into which its points are divided."""

    def half_width(self) -> tuple[float, float, float]:
        """How far the body reaches beyond its points: this [m], or where negative half the edge of a point's cube.

        The edge is (volume · the second number) to the power of the third.
        """


class ContactMembrane(ContactBody, Protocol):
    """A membrane that touches others on the grid."""

    areal_density: float
    """At rest [kg/m²]."""

    def vector_areas(self) -> np.ndarray:
        """The share of its vector area of each point [m²], shape (n, 3), in the order in which these are stored."""


@runtime_checkable
class WarnsOfContact(Protocol):
    """A body whose contact may be too coarse."""

    def contact_warning(self, nodes: np.ndarray) -> str | None:
        """A warning about the body where it touches others at these nodes of the grid, shape (n,), or None."""


@runtime_checkable
class TakesSecondImpulses(Protocol):
    """A body to which contact may give impulses once more after its momentum was mapped to the nodes again."""

    @property
    def takes_second_impulses(self) -> bool:
        """Whether it may now: a condition that prescribes its motion may stand against it."""

    def take_second_impulses(self, dt: float) -> float:
        """Take the second increments of its velocity field at the end of a step dt [s]: kinetic energy won [J], but for a body
        that counts its own works."""


def is_membrane(body: ContactBody) -> TypeGuard[ContactMembrane]:
    """Whether a body is a membrane."""
    return body.is_surface
