"""Intersections of triangulated surfaces, including surfaces that lie on each other."""

from collections.abc import Iterator

import numpy as np

from pellucid.geometry.meshes.triangulation import Triangulation

ROUNDING = 1e-9  # of an edge


def crossing(first: Triangulation, second: Triangulation) -> np.ndarray | None:
    """Return a position [m], shape (3,), where an edge of one of two surfaces intersects a triangle of the other surface;
    None if the surfaces do not intersect.

    An edge or vertex that lies on a triangle counts as an intersection.
    """
    for one, other in ((first, second), (second, first)):
        place = _piercing(one, other, np.arange(len(one.vertices)), -2 - np.arange(len(other.vertices)), True)
        if place is not None:
            return place
    return None


def self_crossing(surface: Triangulation, in_plane: bool = True) -> np.ndarray | None:
    """Return a position [m], shape (3,), where an edge of a surface intersects a triangle that does not share a vertex with
    it; None if there is none.

    Coincident vertices count as one. in_plane: True to also count edges that lie in the plane of a triangle; use False
    for surfaces with layers that touch each other.
    """
    number = np.unique(surface.vertices + 0.0, axis=0, return_inverse=True)[1].reshape(-1)
    return _piercing(surface, surface, number, number, in_plane)


def _piercing(
    one: Triangulation, other: Triangulation, of_one: np.ndarray, of_other: np.ndarray, in_plane: bool
) -> np.ndarray | None:
    """Return the first position [m] where an edge of the surface `one` intersects a triangle of the surface `other`, or
    None; triangles that share a vertex with the edge are ignored. of_one, of_other: a number for each vertex of the
    surfaces, equal for coincident vertices; in_plane: as in `self_crossing`."""
    edges = np.unique(np.sort(one.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1), axis=0)
    start, end = one.vertices[edges[:, 0]], one.vertices[edges[:, 1]]
    corners, numbers = other.vertices[other.triangles], of_other[other.triangles]
    slack = ROUNDING * float(np.ptp(corners, axis=(0, 1)).max())
    lower, upper = other.vertices.min(axis=0) - slack, other.vertices.max(axis=0) + slack
    inside = np.all((np.maximum(start, end) >= lower) & (np.minimum(start, end) <= upper), axis=1)
    edges, start, end = of_one[edges[inside]], start[inside], end[inside]
    if not len(edges):
        return None
    for e, t in BoundingTree(corners, numbers, slack).near(edges, start, end):
        strange = (edges[e][:, :, None] != numbers[t][:, None, :]).all(axis=(1, 2))
        e, t = e[strange], t[strange]
        meets, places = _meeting(start[e], (end - start)[e], corners[t], slack, in_plane)
        if meets.any():
            found = np.flatnonzero(meets)
            return np.asarray(places[found[np.lexsort((t[found], e[found]))[0]]])
    return None


def _meeting(p: np.ndarray, d: np.ndarray, corners: np.ndarray, slack: float, in_plane: bool) -> tuple[np.ndarray, np.ndarray]:
    """Return a mask of the edges, from positions p to p + d [m], shape (k, 3), that intersect their triangles, and the
    intersection points [m].

    corners: triangle tested with each edge [m], shape (k, 3, 3); slack: distance below which a parallel edge lies in the
    plane of its triangle [m]; in_plane: count such edges. Source: Möller & Trumbore 1997, J. Graph. Tools 2, 21.
    """
    a = corners[:, 0]
    u, v = corners[:, 1] - a, corners[:, 2] - a
    normal, h = np.cross(u, v), np.cross(d, v)
    determinant = np.sum(u * h, axis=1)
    along = np.abs(determinant) <= ROUNDING * np.linalg.norm(d, axis=1) * np.linalg.norm(normal, axis=1)
    # an edge parallel to a triangle intersects it if its start lies on the triangle
    scale = np.where(along, np.sum(normal * normal, axis=1), determinant)
    s = p - a
    foot = s - np.sum(s * normal, axis=1)[:, None] / np.sum(normal * normal, axis=1)[:, None] * normal
    q = np.cross(s, u)
    U = np.where(along, np.sum(np.cross(foot, v) * normal, axis=1), np.sum(s * h, axis=1)) / scale
    V = np.where(along, np.sum(np.cross(u, foot) * normal, axis=1), np.sum(d * q, axis=1)) / scale
    share = np.where(along, 0.0, np.sum(v * q, axis=1) / scale)
    height = np.abs(np.sum(s * normal, axis=1)) / np.linalg.norm(normal, axis=1)
    within = (U >= -ROUNDING) & (V >= -ROUNDING) & (U + V <= 1.0 + ROUNDING)
    meets = within & (share >= -ROUNDING) & (share <= 1.0 + ROUNDING) & (~along | (height <= slack))
    return meets & (in_plane | ~along), p + share[:, None] * d


LEAF = 4  # largest number of triangles in a box of the last level
EDGES_AT_ONCE = 20_000
PAIRS_AT_ONCE = 200_000  # pairs of an edge and a box; limits the memory


class BoundingTree:
    """Nested oriented boxes around m triangles with corners [m], shape (m, 3, 3).

    slack: margin added to each side of the boxes [m]; vertices: vertex numbers of the corners, shape (m, 3), equal for
    triangles that share a vertex.

    Each box is aligned with the principal axes of its triangles (Gottschalk, Lin & Manocha 1996, SIGGRAPH, 171), so boxes
    around long facets are thin in any direction. Boxes are split at the median of the triangle centres; all boxes of a level
    are tested at once.
    """

    def __init__(self, corners: np.ndarray, vertices: np.ndarray, slack: float) -> None:
        m = len(corners)
        depth = max(int(np.ceil(np.log2(m / LEAF))), 0)
        self._order = np.arange(m)
        self._bounds = np.arange(2**depth + 1) * m // 2**depth
        self._levels: list[tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]] = []
        centred = corners - corners.mean(axis=(0, 1))
        first, second = centred.sum(axis=1), np.einsum("mki,mkj->mij", centred, centred)
        for level in range(depth + 1):
            bounds = np.arange(2**level + 1) * m // 2**level
            start, count = bounds[:-1], np.diff(bounds)
            order, own = self._order, np.repeat(np.arange(2**level), np.diff(bounds))
            mean = np.add.reduceat(first[order], start) / (3 * count)[:, None]
            spread = np.add.reduceat(second[order], start) / (3 * count)[:, None, None] - mean[:, :, None] * mean[:, None, :]
            axes = np.linalg.eigh(spread)[1].transpose(0, 2, 1)  # in rows
            local = np.einsum("mij,mkj->mki", axes[own], corners[order])
            low, high = np.minimum.reduceat(local.min(axis=1), start), np.maximum.reduceat(local.max(axis=1), start)
            shared = vertices[order][start]  # vertices shared by all triangles of a box, else -1
            has = (vertices[order][:, None, :] == shared[own][:, :, None]).any(axis=2)
            shared = np.where(np.logical_and.reduceat(has, start), shared, -1)
            self._levels.append((axes, 0.5 * (low + high), 0.5 * (high - low) + slack, shared))
            centre = local.mean(axis=1)
            wide = np.maximum.reduceat(centre, start) - np.minimum.reduceat(centre, start)
            along = wide.argmax(axis=1)[own]
            self._order = order[np.lexsort((centre[np.arange(m), along], own))]
        # boxes of the last level are not split, so the order of their triangles does not matter

    def near(self, edges: np.ndarray, start: np.ndarray, end: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield pairs of an edge and a triangle that may intersect it: indices of the edges and of the triangles, shape (p,)
        each, for a part of the edges at a time.

        edges: vertex numbers of the ends, shape (n, 2); triangles that share a vertex with an edge may be omitted. start, end:
        positions of the ends [m], shape (n, 3).
        """
        middle, half = 0.5 * (start + end), 0.5 * (end - start)
        last = len(self._levels) - 1
        for lower in range(0, len(edges), EDGES_AT_ONCE):
            some = np.arange(lower, min(lower + EDGES_AT_ONCE, len(edges)))
            waiting = [(0, some, np.zeros(len(some), np.int64))]
            found, n_found = list[tuple[np.ndarray, np.ndarray]](), 0
            while waiting:
                level, e, box = waiting.pop()
                if len(e) > PAIRS_AT_ONCE:
                    parts = range(0, len(e), PAIRS_AT_ONCE)
                    waiting += [(level, e[k : k + PAIRS_AT_ONCE], box[k : k + PAIRS_AT_ONCE]) for k in reversed(parts)]
                    continue
                meets = _meets(self._levels[level], edges[e], middle[e], half[e], box)
                e, box = e[meets], box[meets]
                if level < last:
                    waiting.append((level + 1, np.repeat(e, 2), (2 * box[:, None] + np.arange(2)).ravel()))
                    continue
                count = self._bounds[box + 1] - self._bounds[box]
                place = np.repeat(self._bounds[box] - np.cumsum(count) + count, count) + np.arange(count.sum())
                found.append((np.repeat(e, count), self._order[place]))
                n_found += len(place)
                if n_found > PAIRS_AT_ONCE or not waiting:
                    yield np.concatenate([one for one, _ in found]), np.concatenate([other for _, other in found])
                    found, n_found = [], 0


def _meets(
    level: tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray],
    edges: np.ndarray,
    middle: np.ndarray,
    half: np.ndarray,
    box: np.ndarray,
) -> np.ndarray:
    """Return a mask of the edges that may intersect a triangle of their boxes. level: axes, centres and half sizes of the
    boxes of one level of the tree, and the vertices that all triangles of a box share; edges: vertex numbers of the ends,
    shape (k, 2); middle, half: middle and half the vector of each edge [m], shape (k, 3); box: index of the box tested
    with each edge, shape (k,).

    An edge is excluded if a separating plane exists (along a side of the box or along the edge), or if all triangles of
    the box share one of its vertices.
    """
    axes, centre, size, shared = (some[box] for some in level)
    away = np.einsum("nij,nj->ni", axes, middle) - centre
    along = np.einsum("nij,nj->ni", axes, half)
    reach = np.abs(along)
    meets = (np.abs(away) <= size + reach).all(axis=1)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        across = np.abs(away[:, i] * along[:, j] - away[:, j] * along[:, i])
        meets &= across <= (size[:, i] * reach[:, j] + size[:, j] * reach[:, i]) * (1.0 + 1e-12)
    return meets & (edges[:, :, None] != shared[:, None, :]).all(axis=(1, 2))
