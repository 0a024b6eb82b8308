"""A shape rotated about axes."""

import numpy as np

from pellucid.geometry.shapes.contract import ActiveAxes, Geometry
from pellucid.geometry.shapes.rotation import Rotations, Turn, turn_about
from pellucid.geometry.shapes.sharp_edges import SharpEdges
from pellucid.model import parameter


class Rotated(Geometry):
    """A shape rotated about axes. On a grid with a thin axis it can only be rotated about that axis."""

    shape: Geometry = parameter("", "shape that is rotated")
    rotate: Rotations = parameter("", "the rotations, in order of application")

    @property
    def turn(self) -> Turn:
        """The composed rotation from the original to the rotated position."""
        return turn_about(self.rotate, self.shape.centre())

    @property
    def is_convex(self) -> bool:
        return self.shape.is_convex

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return a box around the rotated shape, computed from the extents of the original shape (`reach`) along the axes
        rotated back."""
        turn = self.turn
        start = turn.after - turn.matrix @ turn.before
        lower, upper = [-self.shape.reach(-row) for row in turn.matrix], [self.shape.reach(row) for row in turn.matrix]
        return start + lower, start + upper

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        return self.shape.contains(self.turn.back(points), active)

    def measure(self, active: ActiveAxes) -> float:
        return self.shape.measure(active)

    def centre(self) -> np.ndarray:
        return self.turn.after

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        turn, own = self.turn, self.shape.sharp_edges(active, spacing)
        return own._replace(
            corner=turn.forth(own.corner), corner_normal=turn.along(own.corner_normal), edge_normal=turn.along(own.edge_normal)
        )

    def in_own_frame(self, points: np.ndarray) -> tuple[Geometry, np.ndarray]:
        return self.shape.in_own_frame(self.turn.back(points))

    def n_own_points(self) -> int | None:
        return self.shape.n_own_points()

    def own_points(self) -> tuple[np.ndarray, np.ndarray]:
        points, volumes = self.shape.own_points()
        return self.turn.forth(points), volumes
