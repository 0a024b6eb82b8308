"""Space enclosed by a triangulated surface: test whether points lie inside by counting crossings of rays, volume, lids over
the rims of an open surface, equivalent ellipsoid."""

from typing import NamedTuple

import numpy as np

from pellucid.geometry.meshes.cells import corner_areas, vector_areas
from pellucid.geometry.meshes.triangulation import directed_edges, pieces

NUDGE = np.array([0.7548776662e-9, 0.5698402910e-9])
"""Shift of the rays divided by the extent of the surface; the two components are incommensurable, so that no ray intersects a
vertex or an edge."""
NO_VOLUME = 1e-12  # of the cube of the extent
PAIRS_AT_ONCE = 2_000_000  # pairs of a ray and a triangle; limits the memory


def inside(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return a mask of the points [m], shape (n, 3), that lie inside a closed surface, shape (n,).

    A ray is cast along x to each point, which is inside if the ray has crossed an odd number of triangles. Points with the same
    y and z share a ray. A ray crosses a triangle if it lies on the same side of its three edges. The sum for an edge is
    evaluated in the same order for both adjacent triangles, so that rounding cannot open a gap between them.
    """
    if len(points) == 0 or len(triangles) == 0:
        return np.zeros(len(points), dtype=bool)
    y, row = np.unique(points[:, 1], return_inverse=True)
    z, column = np.unique(points[:, 2], return_inverse=True)
    codes, ray_of = np.unique(row * len(z) + column, return_inverse=True)
    rays = np.stack([y[codes // len(z)], z[codes % len(z)]], axis=1)
    lower = vertices.min(axis=0)
    extent = (vertices.max(axis=0) - lower).max()
    ray, x = _crossings((rays - lower[1:]) / extent + NUDGE, (vertices - lower) / extent, triangles)
    # one sorted key for all rays: the number of the ray, and within it the position along x
    span = 4.0
    keys = np.sort(ray * span + np.clip(x, -1.0, 2.0))
    start = np.searchsorted(keys, np.arange(len(rays)) * span - 1.5)
    own = np.clip((points[:, 0] - lower[0]) / extent, -1.25, 2.25)
    before = np.searchsorted(keys, ray_of * span + own) - start[ray_of]
    return np.asarray(before % 2 == 1)


def enclosed_volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume [m³] inside a closed surface by the divergence theorem. vertices [m], shape (n, 3); triangles:
    vertex numbers, shape (m, 3).

    Pieces inside an odd number of other pieces are holes.
    """
    piece = pieces(directed_edges(triangles), len(vertices))[triangles[:, 0]]
    names = np.unique(piece)
    volumes = {name: signed_volume(vertices, triangles[piece == name]) for name in names}
    total = 0.0
    for name in names:
        corner = vertices[triangles[piece == name][:1, 0]]
        around = sum(bool(inside(corner, vertices, triangles[piece == other])[0]) for other in names if other != name)
        total += abs(volumes[name]) * (-1.0) ** around
    return total


def signed_volume(vertices: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume [m³] inside a closed surface, positive if its normals point outward. vertices [m], shape (n, 3);
    triangles: vertex numbers, shape (m, 3)."""
    a, b, c = (vertices - vertices.mean(axis=0))[triangles.T]
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def is_inside_out(vertices: np.ndarray, triangles: np.ndarray) -> bool:
    """Return True if the normals of a closed surface point inward; False if the volume inside is zero up to rounding (a
    flat bag). vertices [m], shape (n, 3); triangles: vertex numbers, shape (m, 3)."""
    return signed_volume(vertices, triangles) < -NO_VOLUME * float(np.ptp(vertices, axis=0).max()) ** 3


def _crossings(rays: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the ray number and the x coordinate [m] of every crossing of a ray along x with a triangle. rays: y and z of
    each ray [m], shape (r, 2); vertices [m], shape (n, 3); triangles: vertex numbers, shape (m, 3)."""
    n_bins = max(1, int(np.sqrt(len(rays))))
    low, high = rays.min(axis=0), rays.max(axis=0)
    scale = n_bins / np.maximum(high - low, 1e-300)

    def bin_of(yz: np.ndarray) -> np.ndarray:
        return np.clip((yz - low) * scale, 0, n_bins - 1).astype(int)

    binned = bin_of(rays)
    code = binned[:, 0] * n_bins + binned[:, 1]
    order = np.argsort(code, kind="stable")
    start = np.searchsorted(code[order], np.arange(n_bins * n_bins + 1))
    corners = vertices[triangles][:, :, 1:]
    bottom, top = corners.min(axis=1), corners.max(axis=1)
    met = np.flatnonzero(np.all((top >= low) & (bottom <= high), axis=1))
    first, last = bin_of(bottom[met]), bin_of(top[met])
    # pairs of a triangle and a row of bins: the rays in them are consecutive in the order of the bins
    which, step = spread(last[:, 0] - first[:, 0] + 1)
    row = (first[which, 0] + step) * n_bins
    begin, end = start[row + first[which, 1]], start[row + last[which, 1] + 1]
    triangle = triangles[met][which]
    found = []
    counts = end - begin
    total = np.concatenate([[0], np.cumsum(counts)])
    for lower in range(0, max(int(total[-1]), 1), PAIRS_AT_ONCE):
        part = slice(*np.searchsorted(total, [lower, lower + PAIRS_AT_ONCE]))
        pair, step = spread(counts[part])
        ray = order[begin[part][pair] + step]
        found.append(_meet(ray, rays, vertices, triangle[part][pair]))
    return np.concatenate([ray for ray, _ in found]), np.concatenate([x for _, x in found])


def spread(counts: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return, for groups with `counts` items each, the index of the group of each item and its index within the group: for
    counts (2, 3), (0, 0, 1, 1, 1) and (0, 1, 0, 1, 2)."""
    which = np.repeat(np.arange(len(counts)), counts)
    return which, np.arange(len(which)) - (np.cumsum(counts) - counts)[which]


def _meet(ray: np.ndarray, rays: np.ndarray, vertices: np.ndarray, triangle: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return, for those pairs of ray and triangle that intersect, the ray number and the x coordinate of the crossing [m].
    ray: ray number of each pair, shape (p,); rays: y and z of each ray [m], shape (r, 2); vertices [m], shape (n, 3);
    triangle: vertex numbers of the triangle of each pair, shape (p, 3)."""
    p = rays[ray]
    sides = np.stack([_side(triangle[:, i], triangle[:, (i + 1) % 3], vertices, p) for i in range(3)])
    hit = np.all(sides > 0.0, axis=0) | np.all(sides < 0.0, axis=0)
    weight = sides[:, hit] / sides[:, hit].sum(axis=0)
    opposite = vertices[triangle[hit][:, [2, 0, 1]], 0].T  # the weight of a corner is the area at the opposite edge
    return ray[hit], np.einsum("ij,ij->j", weight, opposite)


def _side(a: np.ndarray, b: np.ndarray, vertices: np.ndarray, p: np.ndarray) -> np.ndarray:
    """Return twice the signed area, in the plane (y, z) [m²], of triangles between the edge from vertex a to vertex b and
    the position p [m], shape (k,); exactly opposite for the edge from b to a. a, b: vertex numbers, shape (k,); vertices
    [m], shape (n, 3); p: y and z, shape (k, 2)."""
    low, high = np.minimum(a, b), np.maximum(a, b)
    edge = vertices[high, 1:] - vertices[low, 1:]
    away = p - vertices[low, 1:]
    return np.where(a < b, 1.0, -1.0) * (edge[:, 0] * away[:, 1] - edge[:, 1] * away[:, 0])


def heights(points: np.ndarray, vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return for each point [m], shape (n, 3), its signed distance [m] from the plane of the triangle with the nearest
    centre, positive on the side of the normal, shape (n,). vertices [m], shape (v, 3); triangles: vertex numbers, shape (m,
    3)."""
    from scipy.spatial import cKDTree

    corners = vertices[triangles]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    centres = corners.mean(axis=1)
    near = cKDTree(centres).query(points)[1]
    return np.asarray(np.sum((points - centres[near]) * normals[near], axis=1))


LEVEL = 1e-6  # of the longest edge of a rim: tolerance by which an edge lies in a plane perpendicular to an axis
FLAT = 1e-3  # of the extent of a rim: deviation of its points from a plane up to which it is flat
BENT = 0.1  # of the extent of a rim: deviation above which a lid to the mean of its points gives no meaningful volume


class Rims(NamedTuple):
    """The boundary edges of a surface (edges of only one triangle), each in the direction in which its triangle traverses
    the edge."""

    edges: np.ndarray  # (k, 2) vertex numbers of the ends of each edge
    beside: np.ndarray  # (k,) vertex number of the third corner of the triangle at each edge
    number: np.ndarray  # (k,) index of the rim to which each edge belongs


def rims_of(triangles: np.ndarray) -> Rims:
    """Return the boundary edges of triangles, shape (m, 3), grouped into rims. The corners of a triangle are
    counterclockwise about its normal."""
    edges, n = directed_edges(triangles), int(triangles.max(initial=0)) + 1
    _, place, count = np.unique(np.sort(edges, axis=1) @ (n, 1), return_index=True, return_counts=True)
    open_ones = np.sort(place[count == 1])
    edges, beside = edges[open_ones], np.roll(triangles, 1, axis=1).T.ravel()[open_ones]
    return Rims(edges, beside, np.unique(pieces(edges, n)[edges[:, 0]], return_inverse=True)[1].ravel())


class Lids:
    """The lids over the rims of a surface, chosen from the initial positions.

    A flat rim is closed by triangles to the mean of its points. A bent rim whose edges lie in planes perpendicular to axes,
    such as the rim of a quarter sphere in two planes of symmetry, is closed by these planes: component a of the normal is zero
    in planes perpendicular to other axes, so the volume is V = ∫(x_a - c_a) n_a dA, where c_a is the position of the plane
    perpendicular to axis a. There may be only one such plane.
    """

    def __init__(self, places: np.ndarray, triangles: np.ndarray) -> None:
        """Choose the lids of a surface. places: initial positions of its vertices [m], shape (n, 3); triangles: shape (m,
        3)."""
        self.rims = rims_of(triangles)
        number = self.rims.number
        bends = np.array([_bend(places[self.rims.edges[number == rim]]) for rim in range(number.max(initial=-1) + 1)])
        across = self._planes(places)
        in_planes = np.array([bool((across[number == rim] >= 0).all()) for rim in range(len(bends))], dtype=bool)
        by_planes = (bends > FLAT) & in_planes
        counts = [self._number_of_planes(places, across, by_planes[number], axis) for axis in range(3)]
        self._axis = int(np.argmin(counts))
        """Axis a of the volume integral V (see the class)."""
        if min(counts) > 1:
            by_planes[:] = False
        self.bend = float(bends[~by_planes].max(initial=0.0))
        """Largest deviation of the points of a rim from the plane of its lid, divided by the extent of the rim."""
        self._capped = ~by_planes[number]
        self._at_plane = self.rims.edges[~self._capped & (across == self._axis)]

    def _planes(self, places: np.ndarray) -> np.ndarray:
        """Return for each rim edge the axis perpendicular to a coordinate plane that contains the edge, -1 if there is none.
        places: initial positions of the vertices [m], shape (n, 3).

        If there are several, the axis is chosen along which the triangle at the edge extends farthest.
        """
        first, second = (places[self.rims.edges[:, end]] for end in (0, 1))
        lengths = np.linalg.norm(second - first, axis=1)
        longest = np.zeros(self.rims.number.max(initial=-1) + 1)
        np.maximum.at(longest, self.rims.number, lengths)
        level = np.abs(second - first) <= LEVEL * longest[self.rims.number][:, None]
        leaves = np.where(level, np.abs(places[self.rims.beside] - first), -1.0)
        return np.where(level.any(axis=1), np.argmax(leaves, axis=1), -1)

    def _number_of_planes(self, places: np.ndarray, across: np.ndarray, chosen: np.ndarray, axis: int) -> int:
        """Count the different planes perpendicular to an axis that contain the rim edges of the mask `chosen`. places:
        initial positions [m]; across: result of `_planes`."""
        heights = np.sort(places[self.rims.edges[chosen & (across == axis), 0], axis])
        extent = float(np.ptp(places, axis=0).max(initial=0.0))
        return int(np.count_nonzero(np.diff(heights, prepend=-np.inf) > FLAT * extent)) if len(heights) else 0

    def volume(self, places: np.ndarray, areas: np.ndarray) -> float:
        """Return the volume inside the surface and its lids [m³], negative if the normals point inward.

        places: positions of the vertices [m]; areas: vector area of the surface that belongs to each vertex [m²], shape
        (n, 3) each.
        """
        axes = [0, 1, 2] if self._capped.all() else [self._axis]
        at_plane = places[self._at_plane].reshape(-1, 3)
        about = places - (at_plane if len(at_plane) else places).mean(axis=0)  # reduces rounding errors far from the origin
        found = float(np.sum((about * areas)[:, axes]))
        if self._capped.any():
            corners, caps = _caps(self.rims, about)
            caps = caps[self._capped]
            found += float(np.sum((corners[caps].mean(axis=1) * vector_areas(corners, caps))[:, axes]))
        return found / len(axes)


def capped(places: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the vertices [m] and triangles of a surface after each rim is closed by triangles to the mean of its points.
    places: vertices [m], shape (n, 3); triangles: shape (m, 3)."""
    corners, caps = _caps(rims_of(triangles), places)
    return corners, np.concatenate([triangles, caps])


def _caps(rims: Rims, places: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the positions `places` followed by the mean point of each rim [m], and for each edge of a rim its triangle
    with the mean point, as indices of these positions, shape (k, 3)."""
    first = places[rims.edges[:, 0]]
    sums = np.stack([np.bincount(rims.number, first[:, axis]) for axis in range(3)], axis=1)
    means = sums / np.bincount(rims.number)[:, None]
    return np.concatenate([places, means]), np.column_stack([rims.edges[:, 1], rims.edges[:, 0], len(places) + rims.number])


def _bend(edges: np.ndarray) -> float:
    """Return the RMS distance of the points of a rim from the plane that fits them, divided by the extent of the rim; edges:
    their end points [m], shape (k, 2, 3)."""
    sizes = np.linalg.svd(edges[:, 0] - edges[:, 0].mean(axis=0), compute_uv=False)
    return float(sizes[-1] / sizes[0]) if len(sizes) == 3 and sizes[0] > 0.0 else 0.0


class Ellipsoid(NamedTuple):
    """An ellipsoid or ellipse: semi-axes [m], longest first, shape (d,), and their directions as rows of a matrix, shape (d,
    d).

    The ellipsoid with the same ratio M/V of the second moments M = ∫ x⊗x dV about the centroid to the volume V has semi-axes
    sqrt(5 m/V) along the eigenvectors of M with eigenvalues m (Ramanujan & Pozrikidis 1998, J. Fluid Mech. 361, 117, use it for
    capsules).
    """

    axes: np.ndarray
    directions: np.ndarray

    @property
    def deformation(self) -> float:
        """Taylor's deformation parameter (L - B)/(L + B), with the longest semi-axis L and the shortest semi-axis B."""
        return float((self.axes[0] - self.axes[-1]) / (self.axes[0] + self.axes[-1]))

    @property
    def inclination(self) -> float:
        """Angle between the longest axis and the x axis, in the plane of x and y [°], from -90 to 90."""
        x, y = self.directions[0, :2]
        return float((np.degrees(np.arctan2(y, x)) + 90.0) % 180.0 - 90.0)


def surface_area(position: np.ndarray, triangles: np.ndarray) -> float:
    """Return the total area of triangles [m²], without lids over rims. position: vertices [m], shape (n, 3); triangles:
    vertex numbers, shape (m, 3)."""
    a, b, c = position[triangles.T]
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def volume_with_lids(position: np.ndarray, triangles: np.ndarray) -> float:
    """Return the volume enclosed by triangles and the lids over their rims [m³], negative if the normals point inward.
    position: vertices [m], shape (n, 3); triangles: vertex numbers, shape (m, 3)."""
    return Lids(position, triangles).volume(position, corner_areas(position, triangles))


def ellipsoid_of(position: np.ndarray, triangles: np.ndarray) -> Ellipsoid:
    """Return the ellipsoid that has the same second moments about its centroid per volume as the space enclosed by
    triangles and the lids over their rims; its semi-axes and directions are NaN if the volume is zero. position: vertices
    [m], shape (n, 3); triangles: vertex numbers, shape (m, 3)."""
    vertices, closed = capped(position, triangles)
    corners = vertices[closed] - position.mean(axis=0)
    volumes = np.linalg.det(corners) / 6.0
    if abs(float(volumes.sum())) <= NO_VOLUME * float(np.ptp(position, axis=0).max()) ** 3:
        return Ellipsoid(np.full(3, np.nan), np.full((3, 3), np.nan))
    return _with_moments_of(corners, volumes)


def ellipse_of(places: np.ndarray) -> Ellipsoid:
    """Return the ellipse that has the same second moments about its centroid per area as a polygon with the corners
    `places` in order [m], shape (n, 2)."""
    corners = places - places.mean(axis=0)
    sides = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    return _with_moments_of(sides, np.linalg.det(sides) / 2.0)


def _with_moments_of(corners: np.ndarray, measures: np.ndarray) -> Ellipsoid:
    """Return the ellipsoid or ellipse with the second moments per volume or area of t simplices that have a corner at the
    origin. corners: the others [m], shape (t, d, d); measures: signed volumes or areas, shape (t,).

    The integral of x ⊗ x over a simplex is its measure times (Σ c ⊗ c + (Σ c) ⊗ (Σ c)) / ((d + 1)(d + 2)).
    """
    d, whole, sums = corners.shape[2], float(measures.sum()), corners.sum(axis=1)
    first = (measures[:, None] * sums).sum(axis=0) / (d + 1.0)
    centre = (measures[:, None] * sums).sum(axis=0) / ((d + 1.0) * whole)
    second = np.einsum("t,tki,tkj->ij", measures, corners, corners) + np.einsum("t,ti,tj->ij", measures, sums, sums)
    moments, directions = np.linalg.eigh(second / ((d + 1.0) * (d + 2.0)) - np.outer(centre, first))
    axes = np.sqrt((d + 2.0) * np.maximum(moments / whole, 0.0))
    return Ellipsoid(axes[::-1].copy(), directions.T[::-1].copy())
