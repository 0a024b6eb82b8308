"""The region inside a closed surface, and the triangles about it."""

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.algorithms.enclosure import enclosed_volume, inside
from pellucid.geometry.checks.surface_checks import faults
from pellucid.geometry.meshes.triangulation import Triangulation, bounding_box
from pellucid.geometry.shapes.contract import ActiveAxes, Geometry
from pellucid.geometry.shapes.sharp_edges import SharpEdges, edges_of_triangles
from pellucid.geometry.surfaces.surface import Surface
from pellucid.model import parameter


class Inside(Geometry):
    """What a closed triangulated surface encloses, on a grid without thin axes; a piece inside another piece is a hole."""

    surface: Surface = parameter(
        "", "the closed surface: a sphere, a box, a cylinder with its lids, an icosphere, or a file that is closed"
    )

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """The bounds of the surface."""
        return bounding_box(self.surface.triangulate().vertices)

    def reach(self, direction: np.ndarray) -> float:
        """The reach of the vertices of the surface."""
        return float((self.surface.triangulate().vertices @ direction).max())

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        """Points inside: a ray along x from such a point crosses the surface an odd number of times."""
        lower, upper = self.bounds()
        found = np.all((points >= lower) & (points <= upper), axis=1)
        found[found] = inside(points[found], *self.surface.triangulate())
        return found

    def measure(self, active: ActiveAxes) -> float:
        """The enclosed volume [m³], exact for the triangles."""
        return enclosed_volume(*self.surface.triangulate())

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        return edges_of_triangles(self.surface.triangulate())


def closed_triangles(surface: Surface) -> Triangulation:
    """The surface in triangles, normals outward. Raises ValueError with its first fault where it does not enclose a volume."""
    triangulation = surface.triangulate()
    if not surface.closed:
        raise Refusal(
            "the surface is open: it has no inside", "use one that encloses a volume; of files, `closed = true` says so"
        )
    for text, remedy in faults(*triangulation, closed=True):
        raise Refusal(f"of the surface: {text}; only a whole closed surface can be filled", remedy)
    return triangulation
