"""Base class of shapes, i.e. regions of space: bounds, point-in-shape test, volume, sharp edges."""

from abc import abstractmethod

import numpy as np

from pellucid.geometry.shapes.sharp_edges import SharpEdges, no_edges
from pellucid.model import Model

AXES = ("x", "y", "z")
ActiveAxes = tuple[bool, bool, bool]
"""Mask of the active axes, i.e. the axes along which the grid is more than one cell thick."""


class Geometry(Model):
    """A region of space. Its extent along an axis on which the grid is one cell thick is ignored."""

    @abstractmethod
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lower and upper corner of a box around the region [m], shape (3,) each."""

    @abstractmethod
    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        """Return a mask of the points [m], shape (n, 3), that lie inside, shape (n,); active: axes along which the grid is
        more than one cell thick."""

    @abstractmethod
    def measure(self, active: ActiveAxes) -> float:
        """Return the volume [m³]; with one axis that is not active (the grid is one cell thick) the area [m²], with two the
        length [m]."""

    @property
    def is_convex(self) -> bool:
        """True if the shape is known to be convex."""
        return False

    def centre(self) -> np.ndarray:
        """Return the centre of the bounds [m], shape (3,), about which initial rotations act."""
        lower, upper = self.bounds()
        return 0.5 * (lower + upper)

    def reach(self, direction: np.ndarray) -> float:
        """Return the largest extent of the region along a direction d, shape (3,): the maximum of x·d over its positions x [m].

        The default, computed from the corners of the bounds, is an upper bound, exact for a box.
        """
        lower, upper = self.bounds()
        return float(np.maximum(lower * direction, upper * direction).sum())

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        """Return the sharp edges and corners; active: axes along which the grid is more than one cell thick; spacing:
        longest chord by which a curved edge is approximated [m]."""
        return no_edges()

    def in_own_frame(self, points: np.ndarray) -> tuple["Geometry", np.ndarray]:
        """Return the shape before its rotation, and the points [m], shape (n, 3), after the inverse rotation."""
        return self, points

    def n_own_points(self) -> int | None:
        """Return the number of points of the shape's own lattice (see `own_points`), or None if material points are placed
        on the lattice of the grid."""
        return None

    def own_points(self) -> tuple[np.ndarray, np.ndarray]:
        """Return positions [m], shape (n, 3), and volumes [m³], shape (n,), of the material points that the shape defines
        itself."""
        raise NotImplementedError(f"a {type(self).__name__.lower()} has no lattice of its own")
