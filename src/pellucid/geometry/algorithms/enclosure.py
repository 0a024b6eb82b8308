"""Space enclosed by a triangulated surface: test whether points lie inside by counting crossings of rays, volume, heights
above the surface."""

import numpy as np

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
    rays, ray_of = _rays(points[:, 1:])
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


def _rays(yz: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the distinct pairs (y, z) of coordinates of points, one for each ray along x, shape (m, 2), and for each point
    the number of its ray, shape (n,). yz: coordinates y and z of the points, shape (n, 2)."""
    y, row = np.unique(yz[:, 0], return_inverse=True)
    z, column = np.unique(yz[:, 1], return_inverse=True)
    codes, ray_of = np.unique(row * len(z) + column, return_inverse=True)
    return np.stack([y[codes // len(z)], z[codes % len(z)]], axis=1), ray_of


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
