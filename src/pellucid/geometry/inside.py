"""The region inside a closed surface."""

import numpy as np

from pellucid.geometry.enclosure import enclosed_volume, inside
from pellucid.geometry.geometry import ActiveAxes, Geometry
from pellucid.geometry.surfaces import Surface
from pellucid.model import parameter


class Inside(Geometry):
    """What a closed triangulated surface encloses, on a grid without thin axes; a piece inside another piece is a hole."""

    surface: Surface = parameter(
        "", "the closed surface: a sphere, a box, a cylinder with its lids, an icosphere, or a file that is closed"
    )

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Those of the surface."""
        vertices = self.surface.triangulate().vertices
        return vertices.min(axis=0), vertices.max(axis=0)

    def reach(self, direction: np.ndarray) -> float:
        """That of the vertices."""
        return float((self.surface.triangulate().vertices @ direction).max())

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        """Which points a ray along x leaves the region from, having crossed the surface an odd number of times."""
        lower, upper = self.bounds()
        found = np.all((points >= lower) & (points <= upper), axis=1)
        found[found] = inside(points[found], *self.surface.triangulate())
        return found

    def measure(self, active: ActiveAxes) -> float:
        """The enclosed volume [m³], exact for the triangles."""
        return enclosed_volume(*self.surface.triangulate())
