"""An ellipsoid of triangles."""

from typing import Annotated, ClassVar

import numpy as np
from pydantic import Field

from pellucid.geometry.icosphere import Icosphere
from pellucid.geometry.mesh import Mesh, Meshed
from pellucid.model import Vector, parameter

Positive = Annotated[float, Field(gt=0)]


class EllipsoidSurface(Meshed):
    """An ellipsoid: a sphere of triangles, stretched along the axes; 10·4ᵏ + 2 points."""

    centre: Vector = parameter("m", "centre", (0.0, 0.0, 0.0))
    radii: tuple[Positive, Positive, Positive] = parameter("m", "radii along x, y and z")
    refinements: int = parameter("", "how often the triangles of an icosahedron are cut in four", 4, ge=0, le=8)

    closed: ClassVar[bool] = True

    def expected_points(self) -> float:
        """See `Meshed`."""
        return 10.0 * 4.0**self.refinements + 2.0

    def mesh(self) -> Mesh:
        """Normals point outward."""
        sphere = Icosphere(centre=(0.0, 0.0, 0.0), radius=1.0, refinements=self.refinements).mesh()
        return Mesh(np.array(self.centre) + sphere.vertices * np.array(self.radii), sphere.quads, sphere.triangles)
