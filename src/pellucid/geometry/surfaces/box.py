"""Surface of a box."""

from typing import Literal

import numpy as np

from pellucid.geometry.meshes.surface_mesh import Mesh, Meshed, grid_quads
from pellucid.model import AtLeastTwo, Vector, check, parameter

Face = Literal["x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper"]
FACES: tuple[Face, ...] = ("x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper")


class BoxSurface(Meshed):
    """All or some of the six faces of a box, of quadrilaterals that share the points of the edges; normals point outward."""

    lower: Vector = parameter("m", "lower corner")
    upper: Vector = parameter("m", "upper corner; must exceed the lower corner along every axis")
    points: tuple[AtLeastTwo, AtLeastTwo, AtLeastTwo] = parameter("", "number of points along x, y and z")
    open: tuple[Face, ...] = parameter("", 'omitted faces, such as ["z-lower", "z-upper"] for a band', ())

    @check
    def _has_faces(self) -> None:
        for axis, low, high in zip("xyz", self.lower, self.upper, strict=True):
            if low >= high:
                text = f"`upper` must exceed `lower` along {axis}: {high:g} m is not greater than {low:g} m"
                raise ValueError(f"{text}; exchange the two values, or correct one of them")
        if not self._faces:
            raise ValueError("`open` lists all six faces, so no surface is left; remove at least one face from `open`")

    @property
    def _faces(self) -> list[Face]:
        return [face for face in FACES if face not in self.open]

    @property
    def closed(self) -> bool:
        """True if no face is open."""
        return len(self._faces) == len(FACES)

    def expected_points(self) -> float:
        x, y, z = map(float, self.points)
        return 2.0 * (x * y + y * z + z * x)

    def mesh(self) -> Mesh:
        """Return the mesh. The points are ordered by x, y, z, with z fastest; the faces have the order of the tuple `FACES`."""
        lattice, quads = lattice_faces(self.points, self._faces)
        low, high = np.array(self.lower), np.array(self.upper)
        return Mesh(low + lattice / (np.array(self.points) - 1.0) * (high - low), quads)


def lattice_faces(points: tuple[int, int, int], faces: list[Face]) -> tuple[np.ndarray, np.ndarray]:
    """Return the points on faces of a box as integer positions (0 to points - 1 along each axis), shape (n, 3), and
    quadrilaterals as point numbers, shape (q, 4). points: number of points along each axis; faces: names of the faces."""
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
