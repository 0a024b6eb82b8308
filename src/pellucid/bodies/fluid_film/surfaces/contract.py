"""Interface of the geometry of a film: the interpolation between its nodes. Each kind of curve or surface is implemented in its
own file."""

from collections.abc import Mapping
from typing import NamedTuple, Protocol

import numpy as np

from pellucid.bodies.fluid_film.surfaces.operators import Operators
from pellucid.geometry.meshes.cells import Cells


class Shares(NamedTuple):
    """The fractions with which the parts of a film (pieces with a mass of their own, at nodes or elements) share the area at
    each quadrature point.
    """

    part: np.ndarray  # (e, c) numbers of the parts that share the quadrature points of an element
    share: np.ndarray  # (q, c) share of each of these parts in each quadrature point; their sum is 1


class Redistributed(NamedTuple):
    """Nodes after their redistribution along the film, and the new masses of the film's parts."""

    x: np.ndarray  # (n, d) nodal positions [m]
    mass: np.ndarray  # (parts,) masses of the parts [kg]


class FilmGeometry(Protocol):
    """Interface of the geometry of a film with n nodes in d dimensions. The film passes through the points `places`, which may
    differ from its nodes."""

    nodes: np.ndarray
    """Numbers of the nodes of each element, shape (e, m). Elements with fewer nodes repeat one of their nodes, with shape
    functions of zero."""
    axes: tuple[int, ...]
    """The d axes of space along which the film extends."""
    held: np.ndarray
    """Mask of the components that cannot move, such as those perpendicular to an axis of symmetry, shape (n, d)."""
    shares: Shares  # fractions of the mass-carrying parts of the film in the area at each quadrature point

    def operators(self, x: np.ndarray) -> Operators:
        """Return the geometry at the quadrature points, and the operators that map nodal velocities to strain rate, slope and
        change of curvature, for nodes at x [m], shape (n, d).
        """

    def places(self, x: np.ndarray) -> np.ndarray:
        """Interpolate a field with nodal values x, shape (n, k), to the points of the film that belong to its nodes, shape (n,
        k). For positions x [m] these are the points through which the film passes.
        """

    def normals(self, x: np.ndarray) -> np.ndarray:
        """Return the outward unit normals of the film at its nodes, shape (n, d), with nodes at x [m], shape (n, d)."""

    def spacing(self, x: np.ndarray) -> np.ndarray:
        """Return the distance of each node from its nearest neighbour [m], shape (n,), with nodes at x [m], shape (n, d)."""

    def cells(self) -> Cells:
        """Return the lines or triangles between the nodes, which the results contain as cells."""

    def redistributed(self, x: np.ndarray, mass: np.ndarray, moved: np.ndarray) -> Redistributed:
        """Redistribute nodes evenly along the film.

        Returns the new nodes [m], shape (n, d), and the new masses of the parts [kg], shape (parts,); both are unchanged if
        no node needs to move. The total mass is conserved to round-off. moved: displacement of the nodes with the film
        since the last redistribution [m], shape (n, d). Raises RunStopped if elements are too flat.
        """

    def can_wait(self, x: np.ndarray) -> bool:
        """Return True if redistribution of nodes at x [m], shape (n, d), can be postponed if it would increase the stored
        energy."""

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return the arrays for checkpoints on which the shape functions depend, in addition to the nodal positions."""

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the shape functions from the arrays of a checkpoint (see `state_arrays`)."""
