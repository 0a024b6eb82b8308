"""What every shape of a body can do."""

from abc import abstractmethod

import numpy as np

from pellucid.geometry.shapes.sharp_edges import SharpEdges, no_edges
from pellucid.model import Model

AXES = ("x", "y", "z")
ActiveAxes = tuple[bool, bool, bool]
"""Which axes count: those along which the grid is more than one cell thick."""


class Geometry(Model):
    """A region of space. Along an axis that is one cell thick its extent does not count."""

    @abstractmethod
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Lower and upper corner of a box around the region [m], shape (3,) each."""

    @abstractmethod
    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        """Which of the points [m], shape (n, 3), lie inside: booleans, shape (n,)."""

    @abstractmethod
    def measure(self, active: ActiveAxes) -> float:
        """Length, area or volume over the active axes [m, m², m³]."""

    def centre(self) -> np.ndarray:
        """The middle of the bounds [m], shape (3,): the point about which the body turns at the start."""
        lower, upper = self.bounds()
        return 0.5 * (lower + upper)

    def reach(self, direction: np.ndarray) -> float:
        """Largest x·d of its places x [m] along a direction d, shape (3,); not less than that, and
        for a box exact, is what the corners of its bounds give."""
        lower, upper = self.bounds()
        return float(np.maximum(lower * direction, upper * direction).sum())

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        """Return its sharp edges and corners; `spacing` [m]: longest chord of one that is curved."""
        return no_edges()

    def in_own_frame(self, points: np.ndarray) -> tuple["Geometry", np.ndarray]:
        """The shape as it was before it was turned, and points [m], shape (n, 3), turned back with it."""
        return self, points

    def n_own_points(self) -> int | None:
        """Number of points where the shape is filled by a lattice of its own; None where the grid's lattice fills it."""
        return None

    def own_points(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions [m], shape (n, 3), and volumes [m³], shape (n,), of a lattice of its own."""
        raise NotImplementedError(f"a {type(self).__name__.lower()} has no lattice of its own")
