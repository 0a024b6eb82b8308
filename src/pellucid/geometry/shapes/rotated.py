"""A shape that is turned about axes."""

import numpy as np

from pellucid.geometry.shapes.contract import ActiveAxes, Geometry
from pellucid.geometry.shapes.rotation import Rotations, Turn, turn_about
from pellucid.geometry.shapes.sharp_edges import SharpEdges
from pellucid.model import parameter


class Rotated(Geometry):
    """A shape turned about axes. On a grid with a thin axis it can be turned about that axis alone."""

    shape: Geometry = parameter("", "what is turned")
    rotate: Rotations = parameter("", "the rotations, in their order")

    @property
    def turn(self) -> Turn:
        """The rotation from where the shape would be to where it is."""
        return turn_about(self.rotate, self.shape.centre())

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """A box about the turned shape, from how far the shape reaches along directions that are turned back."""
        turn = self.turn
        start = turn.after - turn.matrix @ turn.before
        lower, upper = [-self.shape.reach(-row) for row in turn.matrix], [self.shape.reach(row) for row in turn.matrix]
        return start + lower, start + upper

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        """Which points lie in the shape when turned back."""
        return self.shape.contains(self.turn.back(points), active)

    def measure(self, active: ActiveAxes) -> float:
        """The same as of the shape before it was turned."""
        return self.shape.measure(active)

    def centre(self) -> np.ndarray:
        """Where the shape's centre comes to [m], shape (3,)."""
        return self.turn.after

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        turn, own = self.turn, self.shape.sharp_edges(active, spacing)
        return own._replace(
            corner=turn.forth(own.corner), corner_normal=turn.along(own.corner_normal), edge_normal=turn.along(own.edge_normal)
        )

    def in_own_frame(self, points: np.ndarray) -> tuple[Geometry, np.ndarray]:
        """See `Geometry`."""
        return self.shape.in_own_frame(self.turn.back(points))

    def n_own_points(self) -> int | None:
        """The same as of the shape before it was turned."""
        return self.shape.n_own_points()

    def own_points(self) -> tuple[np.ndarray, np.ndarray]:
        """The points of the shape, turned, and their volumes."""
        points, volumes = self.shape.own_points()
        return self.turn.forth(points), volumes
