"""Surface of a cushion: two sheets joined at their edges, i.e. a flat or slightly inflated bag."""

import numpy as np

from pellucid.geometry.meshes.surface_mesh import Mesh, Meshed, grid_quads
from pellucid.geometry.shapes.cushion import CushionDimensions, dome
from pellucid.model import AtLeastTwo, check, parameter


class CushionSurface(CushionDimensions, Meshed):
    """Two domed rectangular sheets parallel to x and y, joined at their four edges, of quadrilaterals; normals point outward.

    At distances ξ and η from the middle, divided by half the sides, the sheets lie at ± height/2 (1 - ξ²)(1 - η²) from the
    plane of their edges.
    """

    points: tuple[AtLeastTwo, AtLeastTwo] = parameter(
        "", "number of points along x and y of a sheet, or of its upper half; at least 3 if both sheets are whole"
    )

    @check
    def _sheets_lie_apart(self) -> None:
        for axis, n in zip("xy", self.points, strict=True):
            if n == 2 and axis not in self.halved and "z" not in self.halved:
                text = f"with 2 points along {axis} all points lie on the common edges, so the two sheets coincide"
                raise ValueError(f"{text}; use at least 3, or halve the cushion along {axis} or z")

    @property
    def closed(self) -> bool:
        """True if the surface is the whole cushion, i.e. `halved` removes no part."""
        return not self.halved

    def expected_points(self) -> float:
        return 2.0 * self.points[0] * self.points[1]

    def mesh(self) -> Mesh:
        """Return the surface as a mesh. Order of the points: upper sheet row by row along y, then the points of the lower
        sheet that are not on its edges."""
        x, y = (np.linspace(0.0 if axis in self.halved else -1.0, 1.0, n) for axis, n in zip("xy", self.points, strict=True))
        first, second = (a.ravel() for a in np.meshgrid(x, y, indexing="ij"))
        bulge = dome(first, second)
        half = 0.5 * np.array([*self.sides, self.height])
        upper = np.stack([first, second, bulge], axis=1) * half
        quads = grid_quads(*self.points, wrapped=False)
        # at a corner of the cushion three vertices of a quadrilateral belong to both sheets: it must be divided through the
        # fourth vertex, otherwise the triangle of the three would occur twice
        inner = bulge > 0.0
        within = inner[quads]
        fourth = (within.sum(axis=1) == 1) & within[:, [1, 3]].any(axis=1)
        quads[fourth] = np.roll(quads[fourth], -1, axis=1)
        if "z" in self.halved:
            return Mesh(upper + np.array(self.centre_), quads)
        below = np.arange(len(upper))
        below[inner] = len(upper) + np.arange(np.count_nonzero(inner))
        vertices = np.concatenate([upper, upper[inner] * (1.0, 1.0, -1.0)])
        return Mesh(vertices + np.array(self.centre_), np.concatenate([quads, below[quads[:, [0, 3, 2, 1]]]]))
