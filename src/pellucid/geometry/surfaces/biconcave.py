"""Biconcave disc: the shape of a red blood cell."""

from typing import ClassVar

import numpy as np

from pellucid.geometry.meshes.surface_mesh import Mesh, Meshed
from pellucid.geometry.surfaces.icosphere import Icosphere
from pellucid.model import Vector, parameter

C0, C2, C4 = 0.1036, 1.0013, -0.5614
"""Coefficients of z = ±R sqrt(1 - x²) (C0 + C2 x² + C4 x⁴), x = r/R: Evans & Fung 1972, Microvasc. Res. 4, 335, divided by
R."""


class Biconcave(Meshed):
    """A red blood cell at rest, flat along z: the mean of measured cells, with a thickness proportional to the radius."""

    centre: Vector = parameter("m", "centre", (0.0, 0.0, 0.0))
    radius: float = parameter("m", "radius, such as 3.91 um", gt=0)
    refinements: int = parameter("", "number of times the triangles of an icosahedron are divided into four", 4, ge=0, le=8)

    closed: ClassVar[bool] = True

    def expected_points(self) -> float:
        return 10.0 * 4.0**self.refinements + 2.0

    def mesh(self) -> Mesh:
        """Return the mesh: a sphere whose vertices are moved along z; normals point outward."""
        sphere = Icosphere(centre=(0.0, 0.0, 0.0), radius=1.0, refinements=self.refinements).mesh()
        x, y, z = sphere.vertices.T
        square = np.minimum(x * x + y * y, 1.0)
        z = z * (C0 + square * (C2 + square * C4))  # on the sphere |z| is sqrt(1 - x²)
        vertices = np.array(self.centre) + self.radius * np.stack([x, y, z], axis=1)
        return Mesh(vertices, sphere.quads, sphere.triangles)
