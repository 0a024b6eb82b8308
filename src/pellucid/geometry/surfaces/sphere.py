"""Sphere of quadrilaterals."""

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.meshes.surface_mesh import Mesh, Meshed, cut_to_box
from pellucid.geometry.shapes.solids import Box
from pellucid.geometry.surfaces.box import FACES, lattice_faces
from pellucid.model import Vector, check, parameter

REACH = 1e-9  # of the radius: tolerance by which a corner may lie outside the box, so that rounding does not decide


class SphereSurface(Meshed):
    """A sphere: the projected surface of a cube, with lines at equal angles on every face; 6 k² + 2 points, outward normals.

    Source: the equiangular cubed sphere, Ronchi, Iacono & Paolucci 1996, J. Comput. Phys. 124, 93.
    """

    centre: Vector = parameter("m", "centre")
    radius: float = parameter("m", "radius", gt=0)
    divisions: int = parameter("", "number of quadrilaterals along an edge of each face of the cube, k", ge=1, le=2000)
    part: Box | None = parameter(
        "", "box that selects a part of the sphere: quadrilaterals with all corners in it. Default: the whole sphere", None
    )

    @check
    def _has_elements(self) -> None:
        if self.part is not None and not len(self.mesh().quads):
            longest = 2.0 * self.radius * np.sin(0.25 * np.pi / self.divisions)  # in the middle of a face of the cube
            text = f"no quadrilateral of the sphere has all corners in `part`; quadrilaterals are up to {longest:.3g} m wide"
            raise Refusal(text, "enlarge the box, move it to the surface, or increase `divisions`")

    @property
    def closed(self) -> bool:
        """True if the surface is the whole sphere."""
        return self.part is None

    def expected_points(self) -> float:
        return 6.0 * self.divisions**2 + 2.0

    def mesh(self) -> Mesh:
        """Return the mesh. The points have the order of the cube: by x, y, z, with z fastest."""
        k = self.divisions
        lattice, quads = lattice_faces((k + 1, k + 1, k + 1), list(FACES))
        cube = np.tan(0.25 * np.pi * (2.0 * lattice / k - 1.0))
        direction = cube / np.linalg.norm(cube, axis=1)[:, None]
        vertices = np.array(self.centre) + self.radius * direction
        if self.part is None:
            return Mesh(vertices, quads)
        return cut_to_box(vertices, quads, self.part.bounds(), REACH * self.radius)
