"""The surface of a box as a membrane."""

from typing import Literal

import numpy as np

from pellucid.geometry.meshes.surface_mesh import Mesh, Meshed, grid_quads
from pellucid.model import AtLeastTwo, Vector, check, parameter

Face = Literal["x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper"]
FACES: tuple[Face, ...] = ("x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper")


class BoxSurface(Meshed):
    """The six faces of a box, or some of them, of quadrilaterals that share the points of the edges; normals outward."""

    lower: Vector = parameter("m", "lower corner")
    upper: Vector = parameter("m", "upper corner, above the lower one along every axis")
    points: tuple[AtLeastTwo, AtLeastTwo, AtLeastTwo] = parameter("", "points along x, y and z")
    open: tuple[Face, ...] = parameter("", 'faces that are left out, such as ["z-lower", "z-upper"] for a band', ())

    @check
    def _has_faces(self) -> None:
        for axis, low, high in zip("xyz", self.lower, self.upper, strict=True):
            if low >= high:
                raise ValueError(f"upper is not above lower along {axis}: {high:g} m and {low:g} m; exchange or move them")
        if not self._faces:
            raise ValueError("open names all six faces, which leaves no surface; keep one of them")

    @property
    def _faces(self) -> list[Face]:
        return [face for face in FACES if face not in self.open]

    @property
    def closed(self) -> bool:
        """Whether no face is open."""
        return len(self._faces) == len(FACES)

    def expected_points(self) -> float:
        """See `Meshed`."""
        x, y, z = map(float, self.points)
        return 2.0 * (x * y + y * z + z * x)

    def mesh(self) -> Mesh:
        """The points in the order x, y, z, the last one fastest; the faces in the order of their names."""
        lattice, quads = lattice_faces(self.points, self._faces)
        low, high = np.array(self.lower), np.array(self.upper)
        return Mesh(low + lattice / (np.array(self.points) - 1.0) * (high - low), quads)


def lattice_faces(points: tuple[int, int, int], faces: list[Face]) -> tuple[np.ndarray, np.ndarray]:
    """Places of the points on faces of a box, from 0 to points - 1 along each axis, shape (n, 3), and quads, shape (q, 4)."""
    strides = np.array([points[1] * points[2], points[2], 1])
    found = []
    for face in faces:
        axis, upper = "xyz".index(face[0]), face.endswith("upper")
        first, second = (a for a in range(3) if a != axis)
        i, j = (a.ravel() for a in np.meshgrid(np.arange(points[first]), np.arange(points[second]), indexing="ij"))
        code = i * strides[first] + j * strides[second] + (points[axis] - 1) * strides[axis] * upper
        quads = code[grid_quads(points[first], points[second], wrapped=False)]
        outward = upper != (axis == 1)  # x cross z is -y
        found.append(quads if outward else quads[:, ::-1])
    codes, which = np.unique(np.concatenate(found), return_inverse=True)
    return codes[:, None] // strides % np.array(points), which.reshape(-1, 4)
