"""Smooth distances of points from the faces that bound the supports of nodes, combined from the distances to single faces.

D = (Σ ρ_i⁻²)^(-1/2) with the distances ρ_i from the faces, divided by the size of the support. By R-functions, the distance
from a face trimmed by a disc (a segment) or by the three planes through its edges (a triangle) is ρ = sqrt(f² + ¼ (sqrt(t² +
f⁴) - t)²), where f vanishes on the line or plane of the face and t ≥ 0 on the face itself (Biswas & Shapiro 2004, Graph. Models
66, 133; Millán, Sukumar & Arroyo 2015; Mountris et al. 2019, section 3). As f⁴ is added to t², ρ depends on the unit of length;
lengths must first be divided by a length of the problem.
"""

from math import sqrt
from typing import NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import FACE_BLOCK, Lists
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import pointwise

SMOOTHNESS, SHAPE = 2.0, 0.2  # for functions that vanish on single faces, as in cell-based maximum entropy
VANISHING = 1e-13  # distance in sizes of the support below which a point lies on its boundary


class FaceDistances(NamedTuple):
    """The faces that bound the support of each node (the region where its shape function is not zero), and their planes."""

    flat: bool  # True for a mesh of triangles in the plane z = 0
    shape: float  # smoothing factor α of the trimming function of triangles
    size: np.ndarray  # (n,) size of the support of each node [m]
    first: np.ndarray  # (n + 1,) start of the faces of each node in `faces`, and the end of the last
    faces: np.ndarray  # faces of node a: entries first[a] to first[a + 1]
    planes: np.ndarray  # (f, 4, 4) normal, offset [m]: of the face, of planes through its edges (segment: middle, length [m])


def face_distances(mesh: SimplexMesh, shape: float, size: np.ndarray, faces: Lists) -> FaceDistances:
    """Return the data for computing smooth distances of points from the faces that bound the supports of n nodes.

    shape: parameter α of the trimming function, which controls the rounding at edges. size: sizes of the supports [m], shape
    (n,). faces: numbers of the faces of the mesh that bound the support of each node.
    """
    flat = mesh.dimension == 2
    planes = (_segments if flat else _triangles)(mesh.nodes[mesh.faces[0]])
    return FaceDistances(flat, shape, size, *faces, planes)


def no_faces(n: int) -> Lists:
    """Return n empty lists: no faces bound the supports of n nodes."""
    return Lists(np.zeros(n + 1, np.int64), np.zeros(0, np.int64))


def _segments(corners: np.ndarray) -> np.ndarray:
    """Return the entries of `FaceDistances.planes` for segments with given corners, shape (f, 2, 3) [m]: unit normal and offset
    of the line of each segment; middle and length of the segment."""
    along = corners[:, 1] - corners[:, 0]
    length = np.linalg.norm(along, axis=1)
    planes = np.zeros((len(corners), 4, 4))
    planes[:, 0, 0], planes[:, 0, 1] = along[:, 1] / length, -along[:, 0] / length
    planes[:, 0, 3] = -np.einsum("fi,fi->f", planes[:, 0, :3], corners[:, 0])
    planes[:, 1, :3], planes[:, 1, 3] = corners.mean(axis=1), length
    return planes


def _triangles(corners: np.ndarray) -> np.ndarray:
    """Return the entries of `FaceDistances.planes` for triangles with given corners, shape (f, 3, 3) [m]: unit normal and
    offset of the plane of each triangle, and of the three planes through its edges and normal to it, positive inside.

    The corners are in the order of the node numbers, as the functions depend on the order of the edges.
    """
    planes = np.zeros((len(corners), 4, 4))
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    planes[:, 0, :3], planes[:, 0, 3] = normal, -np.einsum("fi,fi->f", normal, corners[:, 0])
    for edge in range(3):
        start, end = corners[:, edge], corners[:, (edge + 1) % 3]
        inward = np.cross(normal, end - start)
        inward /= np.linalg.norm(inward, axis=1)[:, None]
        planes[:, 1 + edge, :3], planes[:, 1 + edge, 3] = inward, -np.einsum("fi,fi->f", inward, start)
    return planes


@pointwise
def _along(plane, x):
    return plane[0] * x[0] + plane[1] * x[1] + plane[2] * x[2] + plane[3]


@pointwise
def _weigh_block(alpha, s):
    """Replace in s the distances f, p1, p2, p3 of a block of faces (see `triangle_trim`) by ρ⁻³ times the derivatives of ρ with
    respect to them, and write ρ⁻² behind them; ρ: trimmed distance, alpha: smoothing factor of `triangle_trim`.

    s: five numbers per face, each for all faces of the block in turn; the last fifth receives ρ⁻².
    """
    for i in range(FACE_BLOCK):  # constant stride, no branch, no sum: the compiler vectorises over faces
        f = s[i]
        t, by_f, by_1, by_2, by_3 = triangle_trim(f, s[FACE_BLOCK + i], s[2 * FACE_BLOCK + i], s[3 * FACE_BLOCK + i], alpha)
        rho, of_f, of_t = trimmed_distance(f, t)
        over = 1.0 / max(rho, VANISHING)
        cube = over * over * over
        s[i] = cube * (of_f + of_t * by_f)
        s[FACE_BLOCK + i] = cube * of_t * by_1
        s[2 * FACE_BLOCK + i] = cube * of_t * by_2
        s[3 * FACE_BLOCK + i] = cube * of_t * by_3
        s[4 * FACE_BLOCK + i] = over * over


@pointwise
def _triangle_sum(fn, x, a, s):
    """Return the sum Σ ρ⁻² and the components of Σ ρ⁻³ ∇ρ over the faces of node a; ρ: trimmed distance of x [m] from a face,
    in units of the support size of the node.

    fn: `FaceDistances`; s: scratch memory for a block of faces.
    """
    over = 1.0 / fn.size[a]
    total = gx = gy = gz = 0.0
    for start in range(fn.first[a], fn.first[a + 1], FACE_BLOCK):
        n = min(FACE_BLOCK, fn.first[a + 1] - start)
        for i in range(n):
            planes = fn.planes[fn.faces[start + i]]
            for k in range(4):
                s[k * FACE_BLOCK + i] = over * _along(planes[k], x)
        _weigh_block(fn.shape, s)
        for i in range(n):
            planes = fn.planes[fn.faces[start + i]]
            total += s[4 * FACE_BLOCK + i]
            for k in range(4):
                weight = s[k * FACE_BLOCK + i]
                gx, gy, gz = gx + weight * planes[k, 0], gy + weight * planes[k, 1], gz + weight * planes[k, 2]
    return total, gx, gy, gz


@pointwise
def _segment_sum(fn, x, a):
    """Return the sum Σ ρ⁻² and the components of Σ ρ⁻³ ∇ρ over the faces of node a, which are segments in the plane z = 0;
    ρ: trimmed distance of x [m] from a face, in units of the support size of the node. fn: `FaceDistances`."""
    total = gx = gy = 0.0
    size = fn.size[a]
    for i in range(fn.first[a], fn.first[a + 1]):
        planes = fn.planes[fn.faces[i]]
        length = planes[1, 3] / size
        dx, dy = (x[0] - planes[1, 0]) / size, (x[1] - planes[1, 1]) / size
        t = (0.25 * length * length - dx * dx - dy * dy) / length
        rho, of_f, of_t = trimmed_distance(_along(planes[0], x) / size, t)
        over = 1.0 / max(rho, VANISHING)
        cube = over * over * over
        total += over * over
        gx += cube * (of_f * planes[0, 0] - 2.0 * of_t / length * dx)
        gy += cube * (of_f * planes[0, 1] - 2.0 * of_t / length * dy)
    return total, gx, gy, 0.0


@pointwise
def inverse_square(fn, x, a, scratch):
    """Return D⁻² = Σ ρ⁻² and the components of D⁻² ∇ln D = Σ ρ⁻³ ∇ρ, where D is the smooth distance of x [m] from the faces
    that bound the support of node a, in units of the support size, and ρ the distance from each of them
    (`trimmed_distance`).

    fn: `FaceDistances`; scratch: memory for a block of faces.
    """
    return _segment_sum(fn, x, a) if fn.flat else _triangle_sum(fn, x, a, scratch)


@pointwise
def share_before_faces(fn, x, a, scratch):
    """Return the factor (1 + D⁻²)^(-s/2), s = SMOOTHNESS, by which faces reduce the weight of node a at x [m], and the
    gradient of the factor times the support size. D: smooth distance of x from the faces that bound the support of the
    node, divided by the support size.

    fn: `FaceDistances`; scratch: memory for a block of faces.
    """
    total, gx, gy, gz = inverse_square(fn, x, a, scratch)
    if total * VANISHING * VANISHING >= 1.0:
        return 0.0, 0.0, 0.0, 0.0
    share = (1.0 + total) ** (-0.5 * SMOOTHNESS)
    factor = share * SMOOTHNESS / (1.0 + total)
    return share, factor * gx, factor * gy, factor * gz


TINY = 1e-150  # avoids division by zero, also by products of two such divisors, where the numerator is zero too


@pointwise
def trimmed_distance(f, t):
    """Return the trimmed distance ρ = sqrt(f² + ¼ (sqrt(t² + f⁴) - t)²) of a point from a face, and its derivatives with
    respect to f and t.

    f: distance of the point from the plane of the face; t: trimming function, positive where the point projects into the
    face. The code has no branches, so that loops over faces can be vectorised.
    """
    V = sqrt(t * t + f * f * f * f) + TINY
    total = V + abs(t)
    gap = f * f * f * f / total if t > 0.0 else total  # V - t, without cancellation
    rho = sqrt(f * f + 0.25 * gap * gap)
    over = 1.0 / ((rho + TINY) * V)
    half = 0.5 * gap
    return rho, (f * V + half * f * f * f) * over, -half * half * over


@pointwise
def triangle_trim(f, p1, p2, p3, alpha):
    """Return the trimming function t of a triangle at a point, positive where the point projects into the triangle, and its
    derivatives with respect to f, p1, p2, p3. For its use see `trimmed_distance`.

    f: distance of the point from the plane of the triangle; p1, p2, p3: distances from the planes through its edges and
    normal to it, positive inside; alpha: smoothing factor at the edges. All distances are in units of the support size.
    """
    G = sqrt(p1 * p1 + p2 * p2 + alpha * f * f)
    over_G = 1.0 / (G + TINY)
    q = p1 + p2 - G
    R = sqrt(q * q + p3 * p3 + alpha * f * f)
    over_R = 1.0 / (R + TINY)
    rest = 1.0 - q * over_R
    by_f = -alpha * f * (over_G * rest + over_R)
    return q + p3 - R, by_f, (1.0 - p1 * over_G) * rest, (1.0 - p2 * over_G) * rest, 1.0 - p3 * over_R
