"""Base class of shapes, i.e. regions of space: bounds, point-in-shape test, volume, sharp edges and corners; interface of
regions of which only the first two are known."""

from abc import abstractmethod
from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np

from pellucid.geometry.meshes.triangulation import Triangulation
from pellucid.model import Model

AXES = ("x", "y", "z")
ActiveAxes = tuple[bool, bool, bool]
"""Mask of the active axes, i.e. the axes along which the grid is more than one cell thick."""


class SharpEdges(NamedTuple):
    """The convex edges and corners of a shape; in two dimensions only its corners.

    Attributes
    ----------
    corner : ndarray, shape (c, 3)
        Positions of the corners and of the ends of edges [m].
    corner_normal : ndarray, shape (c, 3)
        Normalised mean of the outward normals of the adjacent faces; zero at joints of a smooth edge, which are no corners.
    edge : ndarray, shape (e, 2)
        Corners at the ends of each edge.
    edge_normal : ndarray, shape (e, 3)
        Normalised mean of the outward normals of both faces.
    face : ndarray, shape (k, 3)
        Three corners of each plane, counterclockwise seen from outside; in two dimensions two corners and -1, with the outside
        to the right. No rows unless the shape is convex and bounded only by planes.
    """

    corner: np.ndarray
    corner_normal: np.ndarray
    edge: np.ndarray
    edge_normal: np.ndarray
    face: np.ndarray


def no_edges() -> SharpEdges:
    """Return a `SharpEdges` without edges and corners."""
    return SharpEdges(np.zeros((0, 3)), np.zeros((0, 3)), np.zeros((0, 2), int), np.zeros((0, 3)), np.zeros((0, 3), int))


class Space(Protocol):
    """Interface of a region of space whose volume may be unknown, such as the union of shapes that overlap."""

    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lower and upper corner of a box around the region [m], shape (3,) each."""

    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        """Return a mask of the points [m], shape (n, 3), that lie inside, shape (n,); active: axes along which the grid is
        more than one cell thick."""


class Geometry(Model):
    """A region of space. Its extent along an axis on which the grid is one cell thick is ignored."""

    @abstractmethod
    def bounds(self) -> tuple[np.ndarray, np.ndarray]:
        """Return the lower and upper corner of a box around the region [m], shape (3,) each."""

    @abstractmethod
    def contains(self, points: np.ndarray, active: ActiveAxes) -> np.ndarray:
        """Return a mask of the points [m], shape (n, 3), that lie inside, shape (n,); active: axes along which the grid is
        more than one cell thick."""

    @abstractmethod
    def measure(self, active: ActiveAxes) -> float:
        """Return the volume [m³]; with one axis that is not active (the grid is one cell thick) the area [m²], with two the
        length [m]."""

    @property
    def is_convex(self) -> bool:
        """True if the shape is known to be convex."""
        return False

    def centre(self) -> np.ndarray:
        """Return the centre of the bounds [m], shape (3,), about which initial rotations act."""
        lower, upper = self.bounds()
        return 0.5 * (lower + upper)

    def reach(self, direction: np.ndarray) -> float:
        """Return the largest extent of the region along a direction d, shape (3,): the maximum of x·d over its positions x [m].

        The default, computed from the corners of the bounds, is an upper bound, exact for a box.
        """
        lower, upper = self.bounds()
        return float(np.maximum(lower * direction, upper * direction).sum())

    def sharp_edges(self, active: ActiveAxes, spacing: float) -> SharpEdges:
        """Return the sharp edges and corners; active: axes along which the grid is more than one cell thick; spacing:
        longest chord by which a curved edge is approximated [m]."""
        return no_edges()

    def in_own_frame(self, points: np.ndarray) -> tuple["Geometry", np.ndarray]:
        """Return the shape before its rotation, and the points [m], shape (n, 3), after the inverse rotation."""
        return self, points

    def n_own_points(self) -> int | None:
        """Return the number of points of the shape's own lattice (see `own_points`), or None if material points are placed
        on the lattice of the grid."""
        return None

    def own_points(self) -> tuple[np.ndarray, np.ndarray]:
        """Return positions [m], shape (n, 3), and volumes [m³], shape (n,), of the material points that the shape defines
        itself."""
        raise NotImplementedError(f"a {type(self).__name__.lower()} has no lattice of its own")


SHARP = np.cos(np.radians(30.0))
"""An edge is sharp if the cosine of the angle between the normals of its two faces is below this value. The facets of curved
faces meet at smaller angles."""
FLAT = 1e-3  # largest angle between the normals of facets of one plane [rad]; files in single precision need this tolerance
BEHIND = 1e-5  # of the size of a shape: tolerance by which a corner of a convex shape may lie in front of one of its planes


def edges_of_rectangle(lower: np.ndarray, upper: np.ndarray, thin: int) -> SharpEdges:
    """Return the corners of the rectangle between two corners [m], perpendicular to the axis `thin`, along which the grid is
    one cell thick."""
    first, second = (thin + 1) % 3, (thin + 2) % 3
    sign = np.zeros((4, 3))
    sign[:, first], sign[:, second] = (-1, 1, 1, -1), (-1, -1, 1, 1)
    corner = np.where(sign > 0.0, upper, lower)
    corner[:, thin] = 0.5 * (lower + upper)[thin]
    face = np.array([(a, (a + 1) % 4, -1) for a in range(4)])
    return SharpEdges(corner, sign / np.sqrt(2.0), np.zeros((0, 2), int), np.zeros((0, 3)), face)


def edges_of_box(lower: np.ndarray, upper: np.ndarray) -> SharpEdges:
    """Return the edges and corners of an axis-parallel box between the corners `lower` and `upper` [m]."""
    vertices = np.where(np.array(list(np.ndindex(2, 2, 2))) > 0, upper, lower)
    sides = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [corners for a, b, c, d in sides for corners in ((a, b, c), (a, c, d))]
    return edges_of_triangles(Triangulation(vertices, np.array(triangles)))


def edges_of_rims(rims: Sequence[tuple[np.ndarray, float, float]], axis: int, spacing: float) -> SharpEdges:
    """Return circular edges about an axis, divided into chords of at most `spacing` [m].

    rims: for each circle the centre [m], shape (3,); the radius [m], negative if the body lies outside the circle; and the
    direction of the normal of the adjacent end face along the axis, 1 or -1.
    """
    corners, normals = list[np.ndarray](), list[np.ndarray]()
    edges, count = list[np.ndarray](), 0
    for centre, radius, along in rims:
        n = max(12, int(np.ceil(2.0 * np.pi * abs(radius) / spacing)))
        for angle, found in ((np.arange(n), corners), (np.arange(n) + 0.5, normals)):
            way = np.zeros((n, 3))
            way[:, (axis + 1) % 3], way[:, (axis + 2) % 3] = np.cos(2 * np.pi * angle / n), np.sin(2 * np.pi * angle / n)
            if found is corners:
                found.append(centre + abs(radius) * way)
            else:
                way *= np.sign(radius)
                way[:, axis] = along
                found.append(way / np.sqrt(2.0))
        edges.append(count + np.column_stack([np.arange(n), (np.arange(n) + 1) % n]))
        count += n
    return SharpEdges(
        np.concatenate(corners), np.zeros((count, 3)), np.concatenate(edges), np.concatenate(normals), np.zeros((0, 3), int)
    )


def edges_of_triangles(triangulation: Triangulation) -> SharpEdges:
    """Return the sharp convex edges and corners of a closed triangulated surface with outward normals."""
    place, triangles = triangulation
    normal = np.cross(place[triangles[:, 1]] - place[triangles[:, 0]], place[triangles[:, 2]] - place[triangles[:, 0]])
    size = np.linalg.norm(normal, axis=1)
    triangles, normal = triangles[size > 0.0], normal[size > 0.0] / size[size > 0.0][:, None]
    ends = np.sort(np.concatenate([triangles[:, [a, (a + 1) % 3]] for a in range(3)]), axis=1)
    owner = np.tile(np.arange(len(triangles)), 3)
    order = np.lexsort((owner, ends[:, 1], ends[:, 0]))
    ends, owner = ends[order], owner[order]
    second = np.flatnonzero((ends[1:] == ends[:-1]).all(axis=1)) + 1
    pairs, one, other = ends[second], owner[second - 1], owner[second]
    cosine = np.einsum("ij,ij->i", normal[one], normal[other])
    middle = place[triangles].mean(axis=1)
    convex = np.einsum("ij,ij->i", normal[one], middle[other] - middle[one]) < 0.0
    sharp = (cosine < SHARP) & convex
    corner, edge = np.unique(pairs[sharp], return_inverse=True)
    edge = edge.reshape(-1, 2)
    edge_normal = _units(normal[one[sharp]] + normal[other[sharp]])
    ways = _units(place[pairs[sharp][:, 1]] - place[pairs[sharp][:, 0]])
    corner_normal = np.zeros((len(corner), 3))
    for number, vertex in enumerate(corner):
        about = np.flatnonzero((pairs[sharp] == vertex).any(axis=1))
        signs = np.where(pairs[sharp][about, 0] == vertex, 1.0, -1.0)[:, None]
        if len(about) != 2 or float(np.prod(signs)) * float(ways[about[0]] @ ways[about[1]]) > -SHARP:
            corner_normal[number] = edge_normal[about].sum(axis=0)
    smooth = (cosine >= SHARP) & (cosine < np.cos(FLAT))
    bounded = len(corner) > 3 and not smooth.any()
    face = _planes(place, triangles, normal, corner) if bounded else np.zeros((0, 3), int)
    return SharpEdges(place[corner], _units(corner_normal), edge, edge_normal, face)


def _units(vectors: np.ndarray) -> np.ndarray:
    size = np.linalg.norm(vectors, axis=1, keepdims=True)
    return np.asarray(vectors / np.where(size > 0.0, size, 1.0))


def _planes(place: np.ndarray, triangles: np.ndarray, normal: np.ndarray, corner: np.ndarray) -> np.ndarray:
    """Return three corners of each plane that bounds a convex shape, as indices into `corner`; no rows if it is not convex.
    place: vertices [m], shape (n, 3); triangles: shape (m, 3), with unit normals `normal`, shape (m, 3)."""
    slack = BEHIND * float(np.ptp(place[corner], axis=0).max(initial=0.0))
    found: list[np.ndarray] = []
    left = np.ones(len(triangles), bool)
    while left.any():
        way = normal[int(np.argmax(left))]
        height = place[corner] @ way
        same = left & (normal @ way > np.cos(FLAT))
        level = float((place[triangles[same]] @ way).max())
        if (height > level + slack).any():
            return np.zeros((0, 3), int)
        left &= ~same
        on = np.flatnonzero(height > level - slack)
        if len(on) < 3:
            return np.zeros((0, 3), int)
        first = on[0]
        second = on[int(np.argmax(np.linalg.norm(place[corner[on]] - place[corner[first]], axis=1)))]
        across = np.cross(place[corner[second]] - place[corner[first]], place[corner[on]] - place[corner[first]]) @ way
        position = int(np.argmax(np.abs(across)))
        third = on[position]
        found.append(np.array([first, second, third] if across[position] > 0.0 else [first, third, second]))
    return np.array(found)
