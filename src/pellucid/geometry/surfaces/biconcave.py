"""The biconcave disc of a red blood cell."""

from typing import ClassVar

import numpy as np

from pellucid.geometry.meshes.surface_mesh import Mesh, Meshed
from pellucid.geometry.surfaces.icosphere import Icosphere
from pellucid.model import Vector, parameter

C0, C2, C4 = 0.1036, 1.0013, -0.5614
"""Of z = ±R sqrt(1 - x²) (C0 + C2 x² + C4 x⁴), x = r/R: Evans & Fung 1972, Microvasc. Res. 4, 335, over the radius."""


class Biconcave(Meshed):
    """A red cell at rest, flat along z: the mean of measured ones, whose thickness is a fixed part of the radius."""

    centre: Vector = parameter("m", "centre", (0.0, 0.0, 0.0))
    radius: float = parameter("m", "radius, such as 3.91 um", gt=0)
    refinements: int = parameter("", "how often the triangles of an icosahedron are cut in four", 4, ge=0, le=8)

    closed: ClassVar[bool] = True

    def expected_points(self) -> float:
        """See `Meshed`."""
        return 10.0 * 4.0**self.refinements + 2.0

    def mesh(self) -> Mesh:
        """Normals point outward; vertices are those of a sphere, moved along z."""
        sphere = Icosphere(centre=(0.0, 0.0, 0.0), radius=1.0, refinements=self.refinements).mesh()
        x, y, z = sphere.vertices.T
        square = np.minimum(x * x + y * y, 1.0)
        z = z * (C0 + square * (C2 + square * C4))  # on the sphere |z| is sqrt(1 - x²)
        vertices = np.array(self.centre) + self.radius * np.stack([x, y, z], axis=1)
        return Mesh(vertices, sphere.quads, sphere.triangles)
