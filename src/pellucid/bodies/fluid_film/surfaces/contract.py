"""The interface of the geometry of a film: how its nodes span it. One file each for curves and surfaces."""

from collections.abc import Mapping
from typing import NamedTuple, Protocol

import numpy as np

from pellucid.bodies.fluid_film.surfaces.operators import Operators
from pellucid.geometry.meshes.cells import Cells


class Shares(NamedTuple):
    """Parts of the film, each with a mass, that a quadrature point belongs to."""

    part: np.ndarray  # (e, c) numbers of the parts to which the points of an element belong
    share: np.ndarray  # (q, c) how much; of each point 1 in all


class Redistributed(NamedTuple):
    """Nodes moved along the film, and the masses of its parts then."""

    x: np.ndarray  # (n, d) [m]
    mass: np.ndarray  # (parts,) [kg]


class FilmGeometry(Protocol):
    """n nodes in d dimensions that span a film. The film runs through `places`, near its nodes if not through them."""

    nodes: np.ndarray
    """Shape (e, m): numbers of the nodes of each element; repeated, with functions that are zero, where it has fewer."""
    axes: tuple[int, ...]
    """The d axes of space in which it lies."""
    held: np.ndarray
    """Shape (n, d): components that cannot move, as those across an axis of symmetry."""
    shares: Shares

    def operators(self, x: np.ndarray) -> Operators:
        """Rows of the operators for nodes at x [m], shape (n, d)."""

    def places(self, x: np.ndarray) -> np.ndarray:
        """Values on the film at its nodes, shape (n, k), of a field with these values x of the nodes, shape (n, k)."""

    def normals(self, x: np.ndarray) -> np.ndarray:
        """Outward unit normals of the film at its nodes, with these at x [m], shape (n, d) each."""

    def spacing(self, x: np.ndarray) -> np.ndarray:
        """Distance of each node from its nearest neighbour [m], shape (n,)."""

    def cells(self) -> Cells:
        """Lines or triangles between the nodes, for results."""

    def redistributed(self, x: np.ndarray, mass: np.ndarray, moved: np.ndarray) -> Redistributed:
        """Nodes moved along the film to where they are spread evenly, and the masses of its parts [kg], shape (parts,), then;
        both as they are where nothing needs to move. The mass in all is kept to rounding.

        moved: what nodes have gone with the film, to where they are, since they were spread last [m], shape (n, d). Raises
        RunStopped where elements are too flat."""

    def can_wait(self, x: np.ndarray) -> bool:
        """Return True if nodes at x [m], shape (n, d), need not be redistributed yet when that would add energy."""

    def state_arrays(self) -> dict[str, np.ndarray]:
        """The arrays that the functions depend on beside the nodes, for checkpoints."""

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the arrays of a checkpoint."""
