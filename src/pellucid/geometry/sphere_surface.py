"""A sphere of quadrilaterals."""

from typing import ClassVar

import numpy as np

from pellucid.geometry.box_surface import FACES, lattice_faces
from pellucid.geometry.mesh import Mesh, Meshed
from pellucid.model import Vector, parameter


class SphereSurface(Meshed):
    """A sphere: the surface of a cube projected onto it, lines at equal angles on every face; 6 k² + 2 points, normals outward.

    Source: the equiangular cubed sphere, Ronchi, Iacono & Paolucci 1996, J. Comput. Phys. 124, 93.
    """

    centre: Vector = parameter("m", "centre")
    radius: float = parameter("m", "radius", gt=0)
    divisions: int = parameter("", "quadrilaterals along the edge of each of the cube's faces, k", ge=1, le=2000)

    closed: ClassVar[bool] = True

    def mesh(self) -> Mesh:
        """The points in the order of those of the cube: x, y, z, the last one fastest."""
        k = self.divisions
        lattice, quads = lattice_faces((k + 1, k + 1, k + 1), list(FACES))
        cube = np.tan(0.25 * np.pi * (2.0 * lattice / k - 1.0))
        direction = cube / np.linalg.norm(cube, axis=1)[:, None]
        return Mesh(np.array(self.centre) + self.radius * direction, quads)
