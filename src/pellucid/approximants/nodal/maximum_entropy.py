"""Principle of maximum entropy with priors: shape functions from weights.

p_a = w_a exp(λ·(x - x_a)) / Z for nodes at x_a with the prior weights w_a. Z makes the sum of the p_a one. λ makes Σ p_a (x
- x_a) vanish, which is the minimum of the convex function ln Z (Arroyo & Ortiz 2006, Int. J. Numer. Methods Eng. 65, 2167;
Mountris et al. 2019, eqs. 5 to 9).
"""

from math import exp, inf, log, sqrt
from typing import ClassVar, Literal, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import NO_PRIOR, NOT_CONVERGED, OK, Evaluator, FacedApproximant, shape_functions
from pellucid.approximants.nodal.face_distances import (
    SHAPE,
    VANISHING,
    FaceDistances,
    face_distances,
    inverse_square,
    no_faces,
    share_before_faces,
)
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import point_function, pointwise
from pellucid.model import parameter

MOST_ITERATIONS = 100
CLOSE = 1e-13  # tolerance of Σ p_a (x - x_a), in units of the offsets; off the faces one more step squares the error
ROUNDED = 1e-7  # tolerance if no better value can be reached: on edges with single-precision coordinates, as in STL files
FLAT = 1e-15  # fraction of tr J added to its diagonal: J is singular on a face of the convex hull
EXACT = 1e-10  # decrement of ln Z below which round-off may hide the descent
ON_PLANE = 1e-11  # height above a face, in units of the offsets, up to which a node lies in its plane
SHORTEST = 1e-10  # smallest step of the line search


class MaximumEntropyModel(FacedApproximant):
    """Base of the maximum-entropy approximants, whose priors can include distances from faces."""

    remedy: ClassVar[str | None] = (
        'remove `approximant`: the default "cell-based-least-squares" has shape functions at this point'
    )


@pointwise
def _weigh(n, offset, log_prior, l0, l1, l2, p):
    """Fill p (n,) with the maximum-entropy shape functions p_a = w_a exp(λ·(x - x_a)) / Z of n nodes with the priors w_a
    for the multiplier λ = (l0, l1, l2), and return ln Z, where Z makes the sum of the functions one.

    offset: vectors x - x_a in units of a length, shape (n, 3); log_prior: logarithms ln w_a of the priors, shape (n,).
    """
    highest = -inf
    for a in range(n):
        p[a] = log_prior[a] + l0 * offset[a, 0] + l1 * offset[a, 1] + l2 * offset[a, 2]
        highest = max(highest, p[a])
    Z = 0.0
    for a in range(n):
        p[a] = exp(p[a] - highest)
        Z += p[a]
    for a in range(n):
        p[a] /= Z
    return log(Z) + highest


@pointwise
def _moments(n, offset, p, flat):
    """Return r = Σ p_a (x - x_a) for the shape functions p (n,), and the inverse of J = Σ p_a (x - x_a) ⊗ (x - x_a) - r ⊗ r as
    the entries (xx, yy, zz) and (yz, xz, xy).

    offset: vectors x - x_a, shape (n, 3); flat: True if the nodes lie in a plane z = const.
    """
    r0 = r1 = r2 = 0.0
    xx = yy = zz = yz = xz = xy = 0.0
    for a in range(n):
        x, y, z = offset[a, 0], offset[a, 1], offset[a, 2]
        r0 += p[a] * x
        r1 += p[a] * y
        r2 += p[a] * z
        xx += p[a] * x * x
        yy += p[a] * y * y
        zz += p[a] * z * z
        yz += p[a] * y * z
        xz += p[a] * x * z
        xy += p[a] * x * y
    xx, yy, zz = xx - r0 * r0, yy - r1 * r1, zz - r2 * r2
    yz, xz, xy = yz - r1 * r2, xz - r0 * r2, xy - r0 * r1
    small = FLAT * (xx + yy + zz)
    xx, yy, zz = xx + small, yy + small, zz + small
    if flat:  # in two dimensions the third direction is omitted
        zz, yz, xz = 1.0, 0.0, 0.0
    first, second, third = yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy
    determinant = xx * first + xy * second + xz * third
    over = 1.0 / determinant if determinant != 0.0 else 0.0
    diagonal = (first * over, (xx * zz - xz * xz) * over, (xx * yy - xy * xy) * over)
    return (r0, r1, r2), diagonal, ((xy * xz - xx * yz) * over, third * over, second * over)


@pointwise
def entropy_weights(n, flat, offset, log_prior, p):
    """Fill p (n,) with the shape functions of n nodes at a point x; return `OK` or a code of `FAILURES`.

    flat: True if the nodes lie in a plane z = const; offset: vectors x - x_a, divided by a length, shape (n, 3); log_prior:
    logarithms of the priors, shape (n,).
    """
    highest = -inf
    for a in range(n):
        highest = max(highest, log_prior[a])
    if highest == -inf:
        return NO_PRIOR
    l0 = l1 = l2 = 0.0
    least, left = _weigh(n, offset, log_prior, l0, l1, l2, p), inf
    for _ in range(MOST_ITERATIONS):
        (r0, r1, r2), (xx, yy, zz), (yz, xz, xy) = _moments(n, offset, p, flat)
        left = sqrt(r0 * r0 + r1 * r1 + r2 * r2)
        last = left < CLOSE
        d0 = -(xx * r0 + xy * r1 + xz * r2)
        d1 = -(xy * r0 + yy * r1 + yz * r2)
        d2 = -(xz * r0 + yz * r1 + zz * r2)
        slope = r0 * d0 + r1 * d1 + r2 * d2
        if slope >= 0.0:  # J is singular by round-off: use the gradient direction
            d0, d1, d2, slope = -r0, -r1, -r2, -(r0 * r0 + r1 * r1 + r2 * r2)
        t = 1.0
        found = _weigh(n, offset, log_prior, l0 + d0, l1 + d1, l2 + d2, p)
        while found > least + 1e-4 * t * slope and -slope > EXACT and t > SHORTEST:
            t *= 0.5
            found = _weigh(n, offset, log_prior, l0 + t * d0, l1 + t * d1, l2 + t * d2, p)
        l0, l1, l2, least = l0 + t * d0, l1 + t * d1, l2 + t * d2, found
        if last:
            return OK
    return OK if left < ROUNDED else NOT_CONVERGED


@pointwise
def entropy_gradients(n, flat, offset, prior_gradient, p, gradient):
    """Fill `gradient` (3, n) with the gradients ∇p_a of the shape functions p_a (n,), per unit of the offsets.

    flat, offset: as in `entropy_weights`; prior_gradient: gradients g_a = ∇ln w_a of the logarithms of the priors, shape (n,
    3). With M = I + Σ p_a (x - x_a) ⊗ g_a, J of `_moments` and ∇λ = -J⁻¹ M, ∇p_a = p_a (g_a - Σ p_b g_b + ∇λᵀ (x - x_a)).
    """
    _, (xx, yy, zz), (yz, xz, xy) = _moments(n, offset, p, flat)
    for j in range(3):
        mean = m0 = m1 = m2 = 0.0
        for a in range(n):
            if p[a] > 0.0:
                g = p[a] * prior_gradient[a, j]
                mean += g
                m0 += offset[a, 0] * g
                m1 += offset[a, 1] * g
                m2 += offset[a, 2] * g
        m0, m1, m2 = m0 + (j == 0), m1 + (j == 1), m2 + (j == 2)
        d0 = -(xx * m0 + xy * m1 + xz * m2)
        d1 = -(xy * m0 + yy * m1 + yz * m2)
        d2 = -(xz * m0 + yz * m1 + zz * m2)
        for a in range(n):
            turn = d0 * offset[a, 0] + d1 * offset[a, 1] + d2 * offset[a, 2]
            gradient[j, a] = p[a] * (prior_gradient[a, j] - mean + turn) if p[a] > 0.0 else 0.0


@pointwise
def offsets(position, x, active, offset):
    """Fill `offset` (n, 3) with the vectors x - x_a from the active nodes to x, divided by the longest of them, and return the
    length of the longest [m].

    position: positions of all nodes [m], shape (nodes, 3); active: numbers of the n active nodes.
    """
    farthest = 0.0
    for i in range(len(active)):
        a = active[i]
        square = 0.0
        for d in range(3):
            offset[i, d] = x[d] - position[a, d]
            square += offset[i, d] * offset[i, d]
        farthest = max(farthest, square)
    length = sqrt(farthest)
    for i in range(len(active)):
        for d in range(3):
            offset[i, d] /= length
    return length


@pointwise
def to_lengths(gradients, length):
    """Divide gradients (3, n) with respect to scaled offsets by the unit of the offsets, `length` [m], to obtain gradients with
    respect to x [1/m], in place."""
    for j in range(3):
        for a in range(gradients.shape[1]):
            gradients[j, a] /= length


@pointwise
def keep_face(n, normal, offset, log_prior):
    """For a point on a boundary face with the given unit normal, set the priors of the nodes off the plane of the face to
    zero if all nodes with a prior lie on one side of the plane. The shape functions of nodes off the plane vanish on such a
    face.

    n: number of nodes; offset, log_prior: as in `entropy_weights`, changed in place.
    The functions on the face are the limit for a multiplier λ that grows along the normal. Newton's method cannot reach
    this limit if nodes lie close to the plane of the face, as on a curved boundary.
    """
    above = below = False
    for a in range(n):
        height = offset[a, 0] * normal[0] + offset[a, 1] * normal[1] + offset[a, 2] * normal[2]
        if log_prior[a] > -inf:
            above, below = above or height > ON_PLANE, below or height < -ON_PLANE
    if above and below:
        return
    for a in range(n):
        height = offset[a, 0] * normal[0] + offset[a, 1] * normal[1] + offset[a, 2] * normal[2]
        if abs(height) > ON_PLANE:
            log_prior[a] = -inf
        else:  # removes a rounding error that no λ can compensate
            for d in range(3):
                offset[a, d] -= height * normal[d]


@pointwise
def entropy_functions(length, flat, scratch, values, gradients):
    """Fill `values` (n,) with the shape functions of n nodes at a point and `gradients` (3, n) with their gradients [1/m];
    return `OK` or a code of `FAILURES`.

    length: unit of length [m] of `scratch`, which contains the offsets, the logarithms of the priors and the gradients of
    the logarithms; flat: True if the nodes lie in a plane z = const.
    """
    n = len(values)
    if scratch.normal[0] != 0.0 or scratch.normal[1] != 0.0 or scratch.normal[2] != 0.0:
        keep_face(n, scratch.normal, scratch.offset, scratch.log_prior)
    failure = entropy_weights(n, flat, scratch.offset, scratch.log_prior, values)
    if failure == OK and gradients.shape[1] > 0:
        entropy_gradients(n, flat, scratch.offset, scratch.slope, values, gradients)
        to_lengths(gradients, length)
    return failure


class CellMaximumEntropy(NamedTuple):
    """Parameters of cell-based maximum-entropy shape functions for kernels. The prior (weight) of a node depends on the
    distance from the faces that bound the ring of cells around the node."""

    smoothness: float  # exponent s of the priors
    position: np.ndarray  # (n, 3) node positions [m]
    distances: FaceDistances  # faces that bound the ring of cells around each node


class CellMaximumEntropyModel(MaximumEntropyModel):
    """Cell-based maximum entropy: smooth, positive shape functions with supports of rings of cells.

    Lengths in a prior are divided by the size of the ring of its node (the largest distance from the node to a vertex of the
    ring), so that the functions do not depend on the unit of length.

    Source: Millán, Sukumar & Arroyo 2015, Comput. Methods Appl. Mech. Eng. 284, 712, in two dimensions; Mountris et al. 2019,
    section 3, in three.
    """

    kind: Literal["cell-based-maximum-entropy"] = "cell-based-maximum-entropy"
    rings: int = parameter(
        "", "size of a node's support: number of rings of cells around it; 1 gives linear simplex functions", 2, ge=1, le=3
    )
    smoothness: float = parameter(
        "", "exponent s: the prior weight of a node is the distance to the edge of its support to the power s", 2.0, ge=1, le=8
    )
    shape: float = parameter(
        "", "smoothing factor α of the distance function of a triangle, which has kinks for α = 0", 0.2, gt=0, le=8
    )

    @property
    def nodes_in_a_cell(self) -> float:
        return {1: 4.0, 2: 35.0, 3: 116.0}[self.rings]  # measured

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        from pellucid.approximants.nodal.rings import nodes_of_cells, ring_boundaries  # scipy is slow to import

        bounds, size = ring_boundaries(mesh, self.rings)
        distances = face_distances(mesh, self.shape, size, bounds)
        return Evaluator(nodes_of_cells(mesh, self.rings), CellMaximumEntropy(self.smoothness, mesh.nodes, distances))


@pointwise
def _prior(fn, x, a, faces):
    """Return ln w_a = s ln D_a, the logarithm of the prior (weight) of node a at x [m], and the gradient of this logarithm
    times the ring size.

    D_a: smooth distance of x from the faces that bound the ring of cells around the node, divided by the ring size; faces:
    scratch memory for a block of faces. fn: `CellMaximumEntropy`, with the exponent s.
    """
    total, gx, gy, gz = inverse_square(fn.distances, x, a, faces)
    if total == 0.0:  # the ring covers the whole mesh
        return 0.0, 0.0, 0.0, 0.0
    if total * VANISHING * VANISHING >= 1.0:
        return -inf, 0.0, 0.0, 0.0
    factor = fn.smoothness / total
    return -0.5 * fn.smoothness * log(total), factor * gx, factor * gy, factor * gz


@point_function(shape_functions, CellMaximumEntropy)
def _cell_maximum_entropy_functions(functions, cell, x, active, scratch, values, gradients):
    n = len(active)
    length = offsets(functions.position, x, active, scratch.offset)
    for i in range(n):
        prior, gx, gy, gz = _prior(functions, x, active[i], scratch.faces)
        factor = length / functions.distances.size[active[i]]
        scratch.log_prior[i] = prior
        scratch.slope[i, 0], scratch.slope[i, 1], scratch.slope[i, 2] = factor * gx, factor * gy, factor * gz
    return entropy_functions(length, functions.distances.flat, scratch, values, gradients)


NEGLIGIBLE = 1e-8  # prior relative to its value at the node, at which the support is cut off


class LocalMaximumEntropy(NamedTuple):
    """Parameters of the priors: nodes, widths of the Gaussian priors, and distances from faces on which priors vanish (most
    nodes have no such faces)."""

    position: np.ndarray  # (n, 3) node positions [m]
    width: np.ndarray  # (n,) width of the Gaussian prior of each node, h/sqrt(γ) [m]
    distances: FaceDistances  # in units of the mean edge length at a node


class LocalMaximumEntropyModel(MaximumEntropyModel):
    """Local maximum entropy with priors exp(-γ|x - x_a|²/h²), where h is the mean edge length at the node (Arroyo & Ortiz
    2006)."""

    kind: Literal["local-maximum-entropy"] = "local-maximum-entropy"
    locality: float = parameter("", "locality γ: larger values give smaller supports", 2.4, ge=0.5, le=10)

    @property
    def nodes_in_a_cell(self) -> float:
        return 262.0 * (2.4 / self.locality) ** 1.5  # measured at γ = 2.4; the radius of a support is proportional to γ^(-1/2)

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        from pellucid.approximants.nodal.rings import nodes_in_reach  # scipy is slow to import

        width = mesh.spacing / sqrt(self.locality)
        active = nodes_in_reach(mesh, width * sqrt(-log(NEGLIGIBLE)))
        distances = face_distances(mesh, SHAPE, mesh.spacing, no_faces(len(mesh.nodes)))
        return Evaluator(active, LocalMaximumEntropy(mesh.nodes, width, distances))


@point_function(shape_functions, LocalMaximumEntropy)
def _local_maximum_entropy_functions(functions, cell, x, active, scratch, values, gradients):
    n, distances = len(active), functions.distances
    length = offsets(functions.position, x, active, scratch.offset)
    for i in range(n):
        ratio = length / functions.width[active[i]]
        square = 0.0
        for d in range(3):
            square += scratch.offset[i, d] * scratch.offset[i, d]
            scratch.slope[i, d] = -2.0 * ratio * ratio * scratch.offset[i, d]
        scratch.log_prior[i] = -ratio * ratio * square
        if distances.first[active[i]] < distances.first[active[i] + 1]:
            share, gx, gy, gz = share_before_faces(distances, x, active[i], scratch.faces)
            scratch.log_prior[i] += log(share) if share > 0.0 else -inf
            factor = length / (distances.size[active[i]] * share) if share > 0.0 else 0.0
            scratch.slope[i, 0] += factor * gx
            scratch.slope[i, 1] += factor * gy
            scratch.slope[i, 2] += factor * gz
    return entropy_functions(length, distances.flat, scratch, values, gradients)
