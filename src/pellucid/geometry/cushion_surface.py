"""Two sheets that are joined at their edges: a bag that lies flat, or nearly."""

import numpy as np

from pellucid.geometry.cushion import Halves, Positive, dome
from pellucid.geometry.mesh import Mesh, Meshed, grid_quads
from pellucid.geometry.sheets import AtLeastTwo
from pellucid.model import Vector, parameter


class CushionSurface(Meshed):
    """Two rectangular sheets parallel to x and y, domed and joined at their four edges, of quadrilaterals; normals outward.

    At distances ξ and η from the middle, as shares of half the sides, they are ± height/2 (1 - ξ²)(1 - η²) apart from the plane
    of their edges.
    """

    centre: Vector = parameter("m", "middle of the cushion")
    sides: tuple[Positive, Positive] = parameter("m", "lengths along x and y")
    height: float = parameter("m", "distance of the sheets in the middle", gt=0)
    points: tuple[AtLeastTwo, AtLeastTwo] = parameter("", "points along x and y of a sheet, or of its upper half")
    halved: Halves = parameter(
        "", "axes along which only the upper half is kept, for a model with planes of symmetry through the centre", ()
    )

    @property
    def closed(self) -> bool:
        """Whether it is whole."""
        return not self.halved

    def mesh(self) -> Mesh:
        """The upper sheet row by row along y, then the points of the lower one that are not on its edges."""
        x, y = (np.linspace(0.0 if axis in self.halved else -1.0, 1.0, n) for axis, n in zip("xy", self.points, strict=True))
        first, second = (a.ravel() for a in np.meshgrid(x, y, indexing="ij"))
        bulge = dome(first, second)
        half = 0.5 * np.array([*self.sides, self.height])
        upper = np.stack([first, second, bulge], axis=1) * half
        quads = grid_quads(*self.points, wrapped=False)
        if "z" in self.halved:
            return Mesh(upper + np.array(self.centre), quads)
        inner = bulge > 0.0
        below = np.arange(len(upper))
        below[inner] = len(upper) + np.arange(np.count_nonzero(inner))
        vertices = np.concatenate([upper, upper[inner] * (1.0, 1.0, -1.0)])
        return Mesh(vertices + np.array(self.centre), np.concatenate([quads, below[quads[:, [0, 3, 2, 1]]]]))
