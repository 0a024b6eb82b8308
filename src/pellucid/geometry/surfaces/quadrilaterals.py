"""Generated surfaces of quadrilaterals: rectangles, boxes, spheres, cushions, tubes, cylinders."""

from typing import ClassVar, Literal

import numpy as np

from pellucid.findings import Refusal
from pellucid.geometry.meshes.surface_mesh import NO_TRIANGLES, Mesh, Meshed, cut_to_box, grid_quads
from pellucid.geometry.meshes.triangulation import two_across
from pellucid.geometry.shapes.contract import AXES
from pellucid.geometry.shapes.solids import Box, CushionDimensions, dome
from pellucid.geometry.surfaces.triangles import rings_of_a_disc
from pellucid.model import AtLeastThree, AtLeastTwo, Vector, check, parameter


class Rectangle(Meshed):
    """A flat rectangle of quadrilaterals, with its normal along the cross product of its edges."""

    corner: Vector = parameter("m", "position of a corner of the rectangle")
    first_edge: Vector = parameter("m", "edge from the corner")
    second_edge: Vector = parameter("m", "the other edge from the corner")
    points: tuple[AtLeastTwo, AtLeastTwo] = parameter("", "number of points along the first and the second edge")

    closed: ClassVar[bool] = False

    def expected_points(self) -> float:
        return float(self.points[0]) * self.points[1]

    def mesh(self) -> Mesh:
        """Return the mesh, with points ordered row by row along the second edge."""
        n, m = self.points
        s, t = np.meshgrid(np.linspace(0.0, 1.0, n), np.linspace(0.0, 1.0, m), indexing="ij")
        vertices = (
            np.array(self.corner) + s.reshape(-1, 1) * np.array(self.first_edge) + t.reshape(-1, 1) * np.array(self.second_edge)
        )
        return Mesh(vertices, grid_quads(n, m, wrapped=False))


class Lid(Meshed):
    """A face of a box, of quadrilaterals, with an outward normal."""

    box: Box = parameter("", "box, one face of which is the surface")
    face: Literal["x-lower", "x-upper", "y-lower", "y-upper", "z-lower", "z-upper"] = parameter("", "face of the box")
    points: tuple[AtLeastTwo, AtLeastTwo] = parameter(
        "", "number of points along the two axes of the face, in the order x, y, z"
    )

    closed: ClassVar[bool] = False

    def expected_points(self) -> float:
        return float(self.points[0]) * self.points[1]

    def mesh(self) -> Mesh:
        """Return the mesh, with points ordered row by row along the second axis."""
        axis, upper = AXES.index(self.face[0]), self.face.endswith("upper")
        low, high = self.box.bounds()
        corner = low.copy()
        corner[axis] = high[axis] if upper else low[axis]
        first, second = (np.eye(3)[a] * (high - low)[a] for a in range(3) if a != axis)
        edges = {"corner": tuple(corner), "first_edge": tuple(first), "second_edge": tuple(second)}
        mesh = Rectangle(**edges, points=self.points).mesh()
        outward = upper != (axis == 1)  # x cross z is -y
        return mesh if outward else mesh.reversed()


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


class BetweenEnds(Meshed):
    """A circular surface around the line between two points."""

    start: Vector = parameter("m", "centre of one end")
    end: Vector = parameter("m", "centre of the other end")
    radius: float = parameter("m", "radius", gt=0)

    @check
    def _has_a_length(self) -> None:
        if self.start == self.end:
            raise ValueError("`start` and `end` are the same point; move one of them")


class Tube(BetweenEnds):
    """An open circular tube of quadrilaterals; normals point outward."""

    points: tuple[AtLeastThree, AtLeastTwo] = parameter("", "number of points around the circumference, and along the axis")

    part: Box | None = parameter(
        "", "box that selects a part of the tube: quadrilaterals with all corners in it. Default: the whole tube", None
    )

    closed: ClassVar[bool] = False

    @check
    def _has_elements(self) -> None:
        if self.part is not None and not len(self.mesh().quads):
            text = "no quadrilateral of the tube has all corners in `part`"
            raise Refusal(text, "enlarge the box, move it to the surface, or increase `points`")

    def expected_points(self) -> float:
        return float(self.points[0]) * self.points[1]

    def mesh(self) -> Mesh:
        """Return the mesh, with points ordered ring by ring."""
        around, along = self.points
        axis = np.array(self.end) - np.array(self.start)
        side, up = two_across(axis)
        angle = 2.0 * np.pi * np.arange(around) / around
        ring = self.radius * (np.cos(angle)[:, None] * side + np.sin(angle)[:, None] * up)
        s = np.linspace(0.0, 1.0, along)
        vertices = (np.array(self.start) + s[None, :, None] * axis + ring[:, None, :]).reshape(-1, 3)
        quads = grid_quads(around, along, wrapped=True)
        if self.part is None:
            return Mesh(vertices, quads)
        bounds = self.part.bounds()
        part = cut_to_box(vertices, quads, bounds, REACH * self.radius)
        return part._replace(vertices=np.clip(part.vertices, *bounds))  # so that rims lie exactly in the planes of the box


class CylinderSurface(BetweenEnds):
    """A circular cylinder: a mantle of quadrilaterals, and end faces (lids) of triangles that share its edge points;
    outward normals."""

    rings: int = parameter(
        "", "number of rings of points around the centre of a lid; the circumference has 6 × `rings` points", ge=1, le=1000
    )
    along: AtLeastTwo = parameter("", "number of points along the axis, including both ends")
    open: tuple[Literal["start", "end"], ...] = parameter("", "ends without a lid", ())

    @property
    def closed(self) -> bool:
        """True if both ends have lids."""
        return not self.open

    def expected_points(self) -> float:
        return 6.0 * self.rings * (self.along + self.rings)

    def mesh(self) -> Mesh:
        """Return the mesh. Order of the points: mantle in lines along the axis, lid at the start, lid at the end."""
        axis = np.array(self.end) - np.array(self.start)
        side, up = two_across(axis)
        plane, lid = rings_of_a_disc(self.rings)
        inner, around, along = len(plane) - 6 * self.rings, 6 * self.rings, self.along
        disc = self.radius * (plane[:, :1] * side + plane[:, 1:] * up)
        s = np.linspace(0.0, 1.0, along)
        vertices = [(s[None, :, None] * axis + disc[inner:, None, :]).reshape(-1, 3)]
        triangles = [NO_TRIANGLES]
        for end, place in (("start", 0), ("end", 1)):
            if end in self.open:
                continue
            own = sum(map(len, vertices)) + np.arange(inner)
            rim = np.arange(around) * along + place * (along - 1)
            turned = np.concatenate([own, rim])[lid]
            triangles.append(turned if end == "end" else turned[:, ::-1])
            vertices.append(place * axis + disc[:inner])
        quads = grid_quads(around, along, wrapped=True)
        return Mesh(np.array(self.start) + np.concatenate(vertices), quads, np.concatenate(triangles))
