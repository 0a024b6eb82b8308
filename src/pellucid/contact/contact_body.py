"""Interface of a body for contact on the nodes of the grid: its points, their shape functions and its surface."""

from collections.abc import Callable
from typing import Protocol, TypeGuard, runtime_checkable

import numpy as np

from pellucid.approximants import GridFunctions
from pellucid.jit.bundle import Bundle


class ContactResponse(Protocol):
    """Model of a body that integrates its own equation of motion: it computes the nodal velocities that contact impulses on
    the nodes cause. `ContactPairs` calls it in each step with contact."""

    def respond(self) -> None:
        """Set the nodal velocities of the body that result from the contact impulses applied so far in this step."""

    def finish(self) -> None:
        """Copy the resulting velocities to the nodal velocities that move the points of the body. Called once in a step,
        after the contact impulses have converged."""


class ContactBody(Protocol):
    """Body that can be in contact with other bodies on the nodes of the grid."""

    name: str

    @property
    def is_surface(self) -> bool:
        """True if the body is a membrane, whose points can be in contact on both sides (`ContactMembrane`)."""

    @property
    def contact_response(self) -> ContactResponse | None:
        """Response of the body to contact impulses; None if the nodal velocities change by impulse divided by nodal mass."""

    @property
    def n_points(self) -> int:
        """Number of points of the body."""

    @property
    def functions(self) -> GridFunctions:
        """Shape functions of the body's points at the nodes of the grid."""

    @property
    def mapped(self) -> Bundle:
        """Point data, shape functions, grid and slabs, bundled as an argument of kernels."""

    @property
    def n_slabs(self) -> int:
        """Number of slabs (layers of grid cells that one thread processes) into which the points are sorted."""

    def half_width(self) -> tuple[float, float, float]:
        """Return (d, a, b): the distance d of the surface from the points [m], and two numbers a and b.

        If d is negative, each point is instead a cube with the edge length (a · volume)^b, and the surface is half of this
        length away from the point.
        """


class ContactMembrane(ContactBody, Protocol):
    """Membrane that can be in contact with other bodies on the nodes of the grid."""

    areal_density: float
    """Mass per unit area of the undeformed membrane [kg/m²]."""

    def vector_areas(self) -> np.ndarray:
        """Return the vector area of each point [m²], shape (n, 3), in storage order."""


@runtime_checkable
class WarnsOfContact(Protocol):
    """Body that can warn that its surface is too coarse for contact."""

    def contact_warning(self, nodes: np.ndarray) -> str | None:
        """Return a warning if the surface is too coarse at its contact nodes; otherwise None.

        nodes: grid nodes where the body is in contact, shape (n,).
        """


@runtime_checkable
class WarnsOfApproach(Protocol):
    """Body without self-contact that can warn when parts of its surface approach each other."""

    def approach_warning(self, is_filled: Callable[[np.ndarray, float], np.ndarray]) -> str | None:
        """Return a warning if parts of the body's surface have approached each other; otherwise None.

        is_filled: function of positions [m], shape (k, 3), and a distance [m] that returns the mask of positions within
        this distance of other bodies.
        """


@runtime_checkable
class TakesSecondImpulses(Protocol):
    """Body that accepts second contact impulses. At the end of a step, the nodal velocities are mapped from the points
    again; second impulses stop the approach of these velocities."""

    def takes_second_impulses(self) -> bool:
        """Return True if the body accepts second impulses in this step; a prescribed motion may prevent this."""

    def take_second_impulses(self, dt: float) -> float:
        """Add the velocity increments due to the second impulses to the body at the end of a step dt [s]; return the
        resulting gain in kinetic energy [J], or 0 for a body that itself counts the work of second impulses."""


def is_membrane(body: ContactBody) -> TypeGuard[ContactMembrane]:
    """Return True if a body is a membrane."""
    return body.is_surface
