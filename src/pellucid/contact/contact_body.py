"""The interface of a body to contact: its points, how they reach the nodes, and where its surface is."""

from typing import Protocol

import numpy as np

from pellucid.approximants import GridFunctions
from pellucid.contact.faces import Faces
from pellucid.jit.bundle import Bundle


class ContactBody(Protocol):
    """A body that touches others on the grid."""

    name: str
    is_surface: bool
    """Whether the points are those of a membrane, which has two sides."""
    areal_density: float
    """Of a membrane at rest [kg/m²]; of a volume 0."""

    @property
    def n_points(self) -> int:
        """Number of points."""

    @property
    def functions(self) -> GridFunctions:
        """Shape functions between its points and the nodes of the grid."""

    @property
    def mapped(self) -> Bundle:
        """Its points as the kernels of `pellucid.grid.transfer` take them."""

    @property
    def n_slabs(self) -> int:
        """Number of slabs into which its points are divided."""

    def vector_areas(self) -> np.ndarray:
        """Of a membrane, the share of its vector area of each point [m²], shape (n, 3); of a volume none, shape (0, 3)."""

    def half_width(self) -> tuple[float, float, float]:
        """How far the body reaches beyond its points: this [m], or where negative half the edge of a point's cube.

        The edge is (volume · the second number) to the power of the third.
        """

    def faces(self) -> Faces | None:
        """Points on the surface of a volume, where it has such; None of a membrane, all of whose points lie on it."""

    def contact_warning(self, nodes: np.ndarray) -> str | None:
        """A warning about the body where it touches others at these nodes of the grid, shape (n,), or None."""

    @property
    def takes_second_impulses(self) -> bool:
        """Whether contact may give it impulses once more after its momentum was mapped to the nodes again."""

    def take_second_impulses(self, dt: float) -> float:
        """Take the second increments of its velocity field at the end of a step dt [s]: kinetic energy won [J], but for a body
        that counts its own works."""

    def answer_contact(self) -> bool:
        """Let the nodes of the grid have the velocities that contact gave the body so far; False where they have these."""

    def end_contact(self) -> None:
        """Contact is resolved: make what the nodes of the grid answered theirs, where these move the points."""
