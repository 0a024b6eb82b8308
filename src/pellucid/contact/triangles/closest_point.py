"""Kernels for closest points on a triangulated surface, and for signed distances from it.

The closest point of a triangle lies inside the triangle, on one of its edges or at one of its corners (Ericson 2005,
Real-Time Collision Detection, section 5.1.5). The sign of the distance follows from the normal of the triangle, from the
sum of the normals of the two triangles at the edge, or from the sum of the normals at the corner, weighted by the angles
there (Bærentzen & Aanæs 2005, IEEE TVCG 11, 243). With this definition the sign is also correct near sharp edges, and the
distance is continuous.

The gradient of the distance with respect to the position is the unit vector from the closest point to the position. The
gradient with respect to the corners of the triangle is the opposite vector times the barycentric coordinates of the closest
point. Forces that are distributed with these coordinates are therefore derivatives of an energy of the distance.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.jit import kernel, pointwise

INSIDE, EDGE, CORNER = 0, 1, 4
"""Region codes of a closest point on a triangle: INSIDE; EDGE + i on edge i, from corner i to the next corner; CORNER + i
at corner i."""
TINY = 1e-300


class Facets(NamedTuple):
    """Triangulated surface with T triangles and n vertices; the triangles and vertices of images are included."""

    triangle: np.ndarray  # (T, 3) vertices
    place: np.ndarray  # (n, 3) positions of the vertices [m]
    velocity: np.ndarray  # (n, 3) velocities of the vertices [m/s]
    normal: np.ndarray  # (T, 3) unit normals of the triangles
    vertex_normal: np.ndarray  # (n, 3) sums of normals weighted by angles; zero on the rim of an open surface
    beside: np.ndarray  # (T, 3) neighbour triangle at each edge, -1 on the rim
    first: np.ndarray  # (T + 1,) start of the list of each triangle in `neighbour`
    neighbour: np.ndarray  # triangles that share a vertex, in ascending order, including the triangle itself


@pointwise
def closest_shares(x, a, b, c):
    """Return the barycentric coordinates of the point of triangle abc that is closest to x, and its region: `INSIDE` the
    triangle, `EDGE` plus the number of the edge, or `CORNER` plus the number of the corner."""
    ab, ac = (b[0] - a[0], b[1] - a[1], b[2] - a[2]), (c[0] - a[0], c[1] - a[1], c[2] - a[2])
    p = (x[0] - a[0], x[1] - a[1], x[2] - a[2])
    d1, d2 = ab[0] * p[0] + ab[1] * p[1] + ab[2] * p[2], ac[0] * p[0] + ac[1] * p[1] + ac[2] * p[2]
    if d1 <= 0.0 and d2 <= 0.0:
        return 1.0, 0.0, 0.0, CORNER
    p = (x[0] - b[0], x[1] - b[1], x[2] - b[2])
    d3, d4 = ab[0] * p[0] + ab[1] * p[1] + ab[2] * p[2], ac[0] * p[0] + ac[1] * p[1] + ac[2] * p[2]
    if d3 >= 0.0 and d4 <= d3:
        return 0.0, 1.0, 0.0, CORNER + 1
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v = d1 / max(d1 - d3, TINY)
        return 1.0 - v, v, 0.0, EDGE
    p = (x[0] - c[0], x[1] - c[1], x[2] - c[2])
    d5, d6 = ab[0] * p[0] + ab[1] * p[1] + ab[2] * p[2], ac[0] * p[0] + ac[1] * p[1] + ac[2] * p[2]
    if d6 >= 0.0 and d5 <= d6:
        return 0.0, 0.0, 1.0, CORNER + 2
    vb = d5 * d2 - d1 * d6
    if vb <= 0.0 and d2 >= 0.0 and d6 <= 0.0:
        w = d2 / max(d2 - d6, TINY)
        return 1.0 - w, 0.0, w, EDGE + 2
    va = d3 * d6 - d5 * d4
    if va <= 0.0 and d4 >= d3 and d5 >= d6:
        w = (d4 - d3) / max((d4 - d3) + (d5 - d6), TINY)
        return 0.0, 1.0 - w, w, EDGE + 1
    whole = 1.0 / (va + vb + vc)
    return 1.0 - (vb + vc) * whole, vb * whole, vc * whole, INSIDE


@pointwise
def row_of(values, i):
    """Return row i of an array of vectors, shape (n, 3), as three numbers."""
    return values[i, 0], values[i, 1], values[i, 2]


@pointwise
def at_foot(values, triangle, t, u, v, w):
    """Return vertex values, shape (n, 3), interpolated to a point of triangle t with barycentric coordinates u, v, w."""
    a, b, c = triangle[t, 0], triangle[t, 1], triangle[t, 2]
    return (
        u * values[a, 0] + v * values[b, 0] + w * values[c, 0],
        u * values[a, 1] + v * values[b, 1] + w * values[c, 1],
        u * values[a, 2] + v * values[b, 2] + w * values[c, 2],
    )


@pointwise
def closest_on(facets, t, x):
    """Return the barycentric coordinates of the point of triangle t closest to x, its region (see `closest_shares`), and
    the squared distance [m²]."""
    triangle, place = facets.triangle, facets.place
    a, b, c = row_of(place, triangle[t, 0]), row_of(place, triangle[t, 1]), row_of(place, triangle[t, 2])
    u, v, w, region = closest_shares(x, a, b, c)
    e0 = x[0] - (u * a[0] + v * b[0] + w * c[0])
    e1 = x[1] - (u * a[1] + v * b[1] + w * c[1])
    e2 = x[2] - (u * a[2] + v * b[2] + w * c[2])
    return u, v, w, region, e0 * e0 + e1 * e1 + e2 * e2


@pointwise
def normal_at(facets, t, region):
    """Return a normal vector of any length that defines the sign of the distance at a closest point of triangle t; zero on the
    rim.

    region: part of the triangle with the closest point, see `closest_shares`.
    """
    n = row_of(facets.normal, t)
    if region == INSIDE:
        return n
    if region < CORNER:
        q = facets.beside[t, region - EDGE]
        if q < 0:
            return 0.0, 0.0, 0.0
        return n[0] + facets.normal[q, 0], n[1] + facets.normal[q, 1], n[2] + facets.normal[q, 2]
    return row_of(facets.vertex_normal, facets.triangle[t, region - CORNER])


@kernel()
def find_normals(triangle, place, representative, on_rim, normal, vertex_normal):
    """Compute the unit normals of triangles, and at each vertex the sum of the adjacent normals weighted by angles; write them
    to `normal` and `vertex_normal`.

    triangle, place: vertices of the triangles, and positions of the n vertices [m]. representative: number of the vertex that
    represents all vertices at the same position on a plane of symmetry or a seam, shape (n,). on_rim: mask of the vertices on
    the rim, shape (n,); their sum is set to zero.
    """
    for i in range(len(place)):
        vertex_normal[i, 0] = vertex_normal[i, 1] = vertex_normal[i, 2] = 0.0
    for t in range(len(triangle)):
        a, b, c = row_of(place, triangle[t, 0]), row_of(place, triangle[t, 1]), row_of(place, triangle[t, 2])
        u, v = (b[0] - a[0], b[1] - a[1], b[2] - a[2]), (c[0] - a[0], c[1] - a[1], c[2] - a[2])
        n0, n1, n2 = u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]
        size = max(sqrt(n0 * n0 + n1 * n1 + n2 * n2), TINY)
        normal[t, 0], normal[t, 1], normal[t, 2] = n0 / size, n1 / size, n2 / size
        for k in range(3):
            i, j = row_of(place, triangle[t, (k + 1) % 3]), row_of(place, triangle[t, (k + 2) % 3])
            o = row_of(place, triangle[t, k])
            along = 0.0
            for d in range(3):
                along += (i[d] - o[d]) * (j[d] - o[d])
            angle = np.arctan2(size, along)
            at = representative[triangle[t, k]]
            for d in range(3):
                vertex_normal[at, d] += angle * normal[t, d]
    for i in range(len(place)):
        at = representative[i]
        if on_rim[at]:
            vertex_normal[i, 0] = vertex_normal[i, 1] = vertex_normal[i, 2] = 0.0
        elif at != i:
            for d in range(3):
                vertex_normal[i, d] = vertex_normal[at, d]
