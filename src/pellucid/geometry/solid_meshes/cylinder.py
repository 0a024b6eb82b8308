"""Tetrahedral mesh of a circular cylinder: a box mesh whose square cross-section is mapped to a disc."""

from typing import Literal

import numpy as np

from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.shapes.contract import AXES
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.geometry.solid_meshes.contract import Tetrahedral
from pellucid.model import Vector, parameter


class CylinderMesh(Tetrahedral):
    """A tetrahedral mesh of a circular cylinder."""

    base: Vector = parameter("m", "centre of the lower face")
    radius: float = parameter("m", "radius", gt=0)
    height: float = parameter("m", "height along the axis", gt=0)
    axis: Literal["x", "y", "z"] = parameter("", "direction of the axis", "z")
    across: int = parameter("", "number of cubes of the mesh across the diameter; each is divided into twelve tetrahedra", ge=1)
    along: int = parameter("", "number of cubes of the mesh along the axis", ge=1)

    def expected_points(self) -> float:
        return 2.0 * self.across**2 * self.along

    def make(self) -> SimplexMesh:
        """Return the mesh: a box mesh whose cross-section [-1, 1]² is mapped to the disc by (x √(1 - y²/2), y √(1 - x²/2))."""
        square = box_mesh(np.array([-1.0, -1.0, 0.0]), np.ones(3), (self.across, self.across, self.along))
        x, y, z = square.nodes.T
        disc = self.radius * x * np.sqrt(1.0 - 0.5 * y * y), self.radius * y * np.sqrt(1.0 - 0.5 * x * x), self.height * z
        turned = np.roll(np.stack(disc, axis=1), AXES.index(self.axis) - 2, axis=1)  # a cyclic permutation inverts no cell
        return SimplexMesh(np.array(self.base) + turned, square.cells)
