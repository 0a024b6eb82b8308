"""Interface of the geometry of a film, the interpolation between its nodes, and the operators that it computes.

The operators map nodal velocities to strain rate, change of curvature and slope at the quadrature points. A row contains the
coefficients of the velocity components of the nodes of an element, node by node, so that `row · v` is the rate. The virtual
power uses the same rows, and the dissipation their squares. The operator is therefore symmetric, and rigid motions have no
strain rate, to round-off.
"""

from collections.abc import Mapping
from typing import NamedTuple, Protocol

import numpy as np

from pellucid.geometry.meshes.cells import Cells


class Operators(NamedTuple):
    """Shape functions, strain operators and geometry at the q quadrature points of e elements with m nodes each, in d
    dimensions, for given node positions."""

    area: np.ndarray  # (e, q) area that belongs to a quadrature point [m²]
    position: np.ndarray  # (e, q, d) positions of the quadrature points [m]
    normal: np.ndarray  # (e, q, d) outward unit normal
    value: np.ndarray  # (e, q, m, d) shape functions, for each component of the velocity
    strain: np.ndarray  # (e, q, s, m, d) s = 1, 2 or 3 rates of deformation D₁₁, D₂₂, 2 D₁₂ in an orthonormal frame [1/m]
    slope: np.ndarray  # (e, q, c, m, d) gradient of the normal velocity along the c = 1 or 2 axes of this frame [1/m]
    curvature: np.ndarray  # (e, q) J = 2H, the sum of the principal curvatures [1/m], positive for a sphere
    bending: np.ndarray  # (e, q, m, d) rate of change of J at a material point [1/m²]

    def dilatation(self) -> np.ndarray:
        """Return the coefficients that map nodal velocities to the relative rate of change of area, tr D [1/m], shape (e, q,
        m, d).
        """
        first = self.strain[:, :, 0]
        return first if self.strain.shape[2] == 1 else first + self.strain[:, :, 1]

    def volume_rate(self) -> np.ndarray:
        """Return the coefficients that map nodal velocities to the rate of change of the enclosed volume [m²], shape (e, q, m,
        d).
        """
        return np.asarray(self.area[..., None, None] * self.normal[:, :, None, :] * self.value)

    def volume(self) -> float:
        """Return the enclosed volume [m³] by the divergence theorem; for a closed curve, the enclosed area times a depth of
        1 m."""
        d = self.position.shape[2] if self.strain.shape[2] != 2 else 3
        return float(np.einsum("eq,eqi,eqi->", self.area, self.normal, self.position) / d)


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
