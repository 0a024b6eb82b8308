"""The region inside a closed surface, and its triangulation."""

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
    """The region inside a closed triangulated surface, for grids without thin axes; a piece inside another piece is a hole."""

    surface: Surface = parameter(
        "", "closed surface: a sphere, a box, a cylinder with lids, an icosphere, or a closed mesh file"
    )

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        return bounding_box(self.surface.triangulate().vertices)

    def reach(self, direction: np.ndarray) -> float:
        return float((self.surface.triangulate().vertices @ direction).max())

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        lower, upper = self.bounds()
        found = np.all((points >= lower) & (points <= upper), axis=1)
        found[found] = inside(points[found], *self.surface.triangulate())
        return found

    def measure(self, active: ActiveAxes) -> float:
        return enclosed_volume(*self.surface.triangulate())

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        return edges_of_triangles(self.surface.triangulate())


def closed_triangles(surface: Surface) -> Triangulation:
    """Return the triangulation of a surface, with outward normals. Raises ValueError with the first fault of the mesh if the
    surface is not closed."""
    triangulation = surface.triangulate()
    if not surface.closed:
        raise Refusal(
            "the surface is open, so it has no inside", "use a closed surface; for a closed mesh file, set `closed = true`"
        )
    for text, remedy in faults(*triangulation, closed=True):
        raise Refusal(f"the surface cannot be filled: {text}", remedy)
    return triangulation
