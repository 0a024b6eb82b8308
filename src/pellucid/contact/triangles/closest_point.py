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
from pellucid.jit.space import Vector3, add_vector, cross, set_vector, vector_at

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
    ab, ac = b - a, c - a
    p = x - a
    d1, d2 = ab @ p, ac @ p
    if d1 <= 0.0 and d2 <= 0.0:
        return 1.0, 0.0, 0.0, CORNER
    p = x - b
    d3, d4 = ab @ p, ac @ p
    if d3 >= 0.0 and d4 <= d3:
        return 0.0, 1.0, 0.0, CORNER + 1
    vc = d1 * d4 - d3 * d2
    if vc <= 0.0 and d1 >= 0.0 and d3 <= 0.0:
        v = d1 / max(d1 - d3, TINY)
        return 1.0 - v, v, 0.0, EDGE
    p = x - c
    d5, d6 = ab @ p, ac @ p
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
def corners_at(values, triangle, t):
    """Return the rows of an array of vectors, shape (n, 3), for the three vertices of triangle t."""
    return vector_at(values, triangle[t, 0]), vector_at(values, triangle[t, 1]), vector_at(values, triangle[t, 2])


@pointwise
def at_foot(values, triangle, t, u, v, w):
    """Return vertex values, shape (n, 3), interpolated to a point of triangle t with barycentric coordinates u, v, w."""
    a, b, c = corners_at(values, triangle, t)
    return u * a + v * b + w * c


@pointwise
def closest_on(facets, t, x):
    """Return the barycentric coordinates of the point of triangle t closest to x, its region (see `closest_shares`), and
    the squared distance [m²]."""
    a, b, c = corners_at(facets.place, facets.triangle, t)
    u, v, w, region = closest_shares(x, a, b, c)
    e = x - (u * a + v * b + w * c)
    return u, v, w, region, e @ e


@pointwise
def normal_at(facets, t, region):
    """Return a normal vector of any length that defines the sign of the distance at a closest point of triangle t; zero on the
    rim.

    region: part of the triangle with the closest point, see `closest_shares`.
    """
    n = vector_at(facets.normal, t)
    if region == INSIDE:
        return n
    if region < CORNER:
        q = facets.beside[t, region - EDGE]
        return Vector3(0.0, 0.0, 0.0) if q < 0 else n + vector_at(facets.normal, q)
    return vector_at(facets.vertex_normal, facets.triangle[t, region - CORNER])


@kernel()
def find_normals(triangle, place, representative, on_rim, normal, vertex_normal):
    """Compute the unit normals of triangles, and at each vertex the sum of the adjacent normals weighted by angles; write them
    to `normal` and `vertex_normal`.

    triangle, place: vertices of the triangles, and positions of the n vertices [m]. representative: number of the vertex that
    represents all vertices at the same position on a plane of symmetry or a seam, shape (n,). on_rim: mask of the vertices on
    the rim, shape (n,); their sum is set to zero.
    """
    zero = Vector3(0.0, 0.0, 0.0)
    for i in range(len(place)):
        set_vector(vertex_normal, i, zero)
    for t in range(len(triangle)):
        a, b, c = corners_at(place, triangle, t)
        across = cross(b - a, c - a)
        size = max(sqrt(across @ across), TINY)
        n = across / size
        set_vector(normal, t, n)
        for k in range(3):
            i, j = vector_at(place, triangle[t, (k + 1) % 3]), vector_at(place, triangle[t, (k + 2) % 3])
            o = vector_at(place, triangle[t, k])
            angle = np.arctan2(size, (i - o) @ (j - o))
            add_vector(vertex_normal, representative[triangle[t, k]], angle * n)
    for i in range(len(place)):
        at = representative[i]
        if on_rim[at]:
            set_vector(vertex_normal, i, zero)
        elif at != i:
            set_vector(vertex_normal, i, vector_at(vertex_normal, at))
