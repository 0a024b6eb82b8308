"""The region that the mesh of a solid fills."""

import numpy as np

from pellucid.geometry.cells import outer_faces
from pellucid.geometry.enclosure import inside
from pellucid.geometry.geometry import ActiveAxes, Geometry
from pellucid.geometry.solid_meshes import SolidMesh
from pellucid.model import parameter


class MeshRegion(Geometry):
    """What the tetrahedra of a mesh fill, on a grid without thin axes."""

    mesh: SolidMesh = parameter("", "its tetrahedra")

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Those of the nodes."""
        nodes = self.mesh.mesh().nodes
        return nodes.min(axis=0), nodes.max(axis=0)

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        """Which points lie within its outer faces."""
        mesh = self.mesh.mesh()
        return inside(points, mesh.nodes, outer_faces(mesh.cells))

    def measure(self, active: ActiveAxes) -> float:
        """Its volume [m³]."""
        return float(self.mesh.mesh().volumes.sum())
