"""Surface meshes of quadrilaterals and triangles that share vertices, and merging of coincident vertices."""

from abc import abstractmethod
from typing import NamedTuple

import numpy as np

from pellucid.geometry.choice import Countable
from pellucid.geometry.meshes.cells import cut_in_two
from pellucid.geometry.meshes.points import SINGLE
from pellucid.geometry.meshes.triangulation import Triangulation, directed_edges, first_of_each, pieces

NO_QUADS = np.zeros((0, 4), np.int64)
NO_TRIANGLES = np.zeros((0, 3), np.int64)


class Mesh(NamedTuple):
    """Vertices [m], shape (n, 3), quadrilaterals, shape (q, 4), and triangles, shape (t, 3), counterclockwise about the normal.

    Elements are numbered consecutively: quadrilaterals from 0, then triangles from q.
    """

    vertices: np.ndarray
    quads: np.ndarray = NO_QUADS
    triangles: np.ndarray = NO_TRIANGLES

    def triangulated(self) -> Triangulation:
        """Return the triangulation: quadrilaterals divided from their first to their third corner, then the triangles."""
        return Triangulation(self.vertices, np.concatenate([cut_in_two(self.quads), self.triangles]))

    def centres(self) -> np.ndarray:
        """Return the mean corner positions of the elements [m], shape (q + t, 3)."""
        return np.concatenate([self.vertices[corners].mean(axis=1) for corners in (self.quads, self.triangles)])

    def reversed(self) -> "Mesh":
        """Return the mesh with reversed normals. Quadrilaterals keep their first corner, so their triangulation is the same."""
        return Mesh(self.vertices, self.quads[:, [0, 3, 2, 1]], self.triangles[:, ::-1].copy())


class Meshed(Countable):
    """A surface of a case, given as a mesh. Subclasses also define `closed`: True if the surface encloses a volume."""

    @abstractmethod
    def mesh(self) -> Mesh:
        """Return the surface as quadrilaterals and triangles."""

    def triangulate(self) -> Triangulation:
        """Return the triangulation of the mesh, with the same vertices."""
        return self.mesh().triangulated()


def grid_quads(n: int, m: int, wrapped: bool) -> np.ndarray:
    """Return the quadrilaterals between neighbouring points of a grid of n × m points, shape (q, 4); points are numbered
    row by row, n rows of m points; if wrapped, the last row is connected to the first."""
    i, j = np.meshgrid(np.arange(n if wrapped else n - 1), np.arange(m - 1), indexing="ij")
    a, b = (i * m + j).ravel(), ((i + 1) % n * m + j).ravel()
    return np.stack([a, b, b + 1, a + 1], axis=1)


def cut_to_box(vertices: np.ndarray, quads: np.ndarray, bounds: tuple[np.ndarray, np.ndarray], reach: float) -> Mesh:
    """Return the mesh of those quadrilaterals, shape (q, 4), that have all four corners in a box.

    bounds: lower and upper corner of the box [m], shape (3,) each. reach: largest distance of an accepted corner from the
    box [m].
    """
    lower, upper = bounds
    inside = np.asarray(((vertices >= lower - reach) & (vertices <= upper + reach)).all(axis=1))
    used, which = np.unique(quads[inside[quads].all(axis=1)], return_inverse=True)
    return Mesh(vertices[used], which.reshape(-1, 4))


ROUNDING = 1e-9  # of the mean edge: distance below which two points of a file are coincident
MOST = 1e-6  # upper bound of this distance for files in single precision, at any distance from the origin


def rounding_of(points: np.ndarray, elements: list[np.ndarray], is_single: bool) -> float:
    """Return the distance below which two points of a file differ only by rounding, in the unit of the points.

    elements: point numbers of the corners, shape (m, corners), for each kind of element; is_single: True if the file
    stores single precision.
    """
    edges = [np.linalg.norm(points[corners] - points[np.roll(corners, 1, axis=1)], axis=2).ravel() for corners in elements]
    lengths = np.concatenate([np.zeros(0), *edges])
    mean = float(lengths.mean()) if len(lengths) else 0.0
    return min(max(ROUNDING * mean, SINGLE * float(np.abs(points).max())), MOST * mean) if is_single else ROUNDING * mean


def place_of_each(points: np.ndarray, limit: float) -> np.ndarray:
    """Return for each of n points, shape (n, 3), the smallest number of a point no farther away than `limit`, shape (n,)."""
    from scipy.spatial import cKDTree

    different, first, which = np.unique(points + 0.0, axis=0, return_index=True, return_inverse=True)  # + 0.0: -0.0 is 0.0
    if limit > 0.0 and len(pairs := cKDTree(different).query_pairs(limit, output_type="ndarray")):
        group = pieces(pairs, len(different))
        smallest = np.full(len(different), len(points))
        np.minimum.at(smallest, group, first)
        first = smallest[group]
    return np.asarray(first[which.reshape(-1)])


def joined(
    points: np.ndarray, quads: np.ndarray, triangles: np.ndarray, limit: float, closed: bool = False
) -> tuple[np.ndarray, int]:
    """Return for each of n points the index of the point it is merged into, shape (n,), and the number of coincident vertices
    that stay separate. quads, triangles: point numbers of the elements.

    Points at a distance of at most `limit` are merged into the first of them. If elements with separate vertices would then
    coincide, as the two layers of a flat bag do, only vertices on the rims of the sheets are merged. This requires that the
    layers share their rim in the file or that the surface is `closed`; otherwise a sheet that is stored twice would become a
    bag.
    """
    place = place_of_each(points, limit)
    if not _is_crowded(place[quads], place[triangles], len(points)):
        return place, 0
    edges = np.concatenate([directed_edges(quads), directed_edges(triangles)])
    code, count = np.unique(edges.min(axis=1) * len(points) + edges.max(axis=1), return_counts=True)
    is_rim, is_used = np.zeros(len(points), bool), np.zeros(len(points), bool)
    is_used[edges] = True
    once = code[count == 1]
    is_rim[once // len(points)] = is_rim[once % len(points)] = True
    inner = np.flatnonzero(is_used & ~is_rim)
    apart = place.copy()
    apart[inner] = inner
    first = np.zeros(len(points), np.int64)  # one of the inner vertices at each position
    first[place[inner]] = inner
    is_inner_place = np.zeros(len(points), bool)
    is_inner_place[place[inner]] = True
    piece = pieces(apart[edges] if closed else edges, len(points))
    is_one = (piece[inner] == piece[first[place[inner]]]).all()
    if not is_one or is_inner_place[place[is_rim]].any() or _is_crowded(apart[quads], apart[triangles], len(points)):
        return place, 0
    return apart, len(inner) - int(is_inner_place.sum())


def layers_parted(mesh: Mesh) -> Mesh | None:
    """Return a mesh with two layers, joined at their rim, for elements that occur twice with opposite orientation.

    Returns None if the elements do not form such layers. Files that repeat the corners of every element (STL) store a flat
    bag this way. Elements are neighbours across an edge if they have the same orientation and are not the two coincident
    elements, except at the rim, where only these two exist.
    """
    corners = [*mesh.quads.tolist(), *mesh.triangles.tolist()]
    twins: dict[frozenset[int], list[int]] = {}
    for number, element in enumerate(corners):
        twins.setdefault(frozenset(element), []).append(number)
    twin = {some[k]: some[1 - k] for some in twins.values() if len(some) == 2 for k in (0, 1)}
    if not twin or any(len(some) > 2 for some in twins.values()):
        return None
    of_edge: dict[frozenset[int], list[tuple[int, int]]] = {}  # element and start of the edge
    for number, element in enumerate(corners):
        for start, end in zip(element, element[1:] + element[:1], strict=True):
            of_edge.setdefault(frozenset((start, end)), []).append((number, start))
    starts = np.cumsum([0, *map(len, corners)])
    links = []
    for edge, users in of_edge.items():
        rest = dict(users)
        if len(users) > 2 and not all(number in twin for number in rest):
            return None
        while rest:
            one, start = rest.popitem()
            fitting = [other for other, its_start in rest.items() if its_start != start]
            chosen = [other for other in fitting if other != twin.get(one)] or fitting
            if not chosen:
                continue
            del rest[chosen[0]]
            links += [[starts[k] + corners[k].index(vertex) for k in (one, chosen[0])] for vertex in edge]
    group = pieces(np.array(links, np.int64).reshape(-1, 2), int(starts[-1]))
    vertex_of = np.array([vertex for element in corners for vertex in element])
    _, first = np.unique(group, return_index=True)
    order = np.argsort(vertex_of[first], kind="stable")
    number_of = np.empty(len(group), np.int64)
    number_of[group[first[order]]] = np.arange(len(first))
    new = number_of[group]
    n_quads = mesh.quads.size
    parted = Mesh(mesh.vertices[vertex_of[first[order]]], new[:n_quads].reshape(-1, 4), new[n_quads:].reshape(-1, 3))
    piece = pieces(np.concatenate([directed_edges(parted.quads), directed_edges(parted.triangles)]), len(parted.vertices))
    of_element = piece[new[starts[:-1]]]
    is_joined = all(of_element[one] == of_element[other] for one, other in twin.items())
    return parted if is_joined and not _is_crowded(parted.quads, parted.triangles, len(parted.vertices)) else None


def _is_crowded(quads: np.ndarray, triangles: np.ndarray, n: int) -> bool:
    """Return True if two elements have the same corners, or an edge has more than two elements; n: number of vertices."""
    if not (first_of_each(quads).all() and first_of_each(triangles).all()):
        return True
    edges = np.concatenate([directed_edges(quads), directed_edges(triangles)])
    code = np.sort(edges.min(axis=1) * n + edges.max(axis=1))
    return bool((code[2:] == code[:-2]).any())
