"""Moving least squares with polynomials: shape functions from nodal weights and their gradients.

A node at x_a with the weight w_a has the shape function p_a = w_a p(x - x_a)·M⁻¹ p(0) with M = Σ_a w_a p ⊗ p. The basis p
is linear, or quadratic with a small penalty on its quadratic coefficients, which keeps M regular wherever the linear terms
are (Belytschko, Lu & Gu 1994, Int. J. Numer. Methods Eng. 37, 229; Joldes et al. 2015, Appl. Math. Comput. 266, 893).
"""

from typing import ClassVar, Literal, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import OK, SINGULAR_MOMENTS, Evaluator, FacedApproximant, shape_functions
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

LINEAR, QUADRATIC = 4, 10  # number of terms of a basis in three dimensions
PENALTY = 1e-7  # on quadratic coefficients, relative to the sum of the weights, in units of the support size
SINGULAR = 1e-13  # pivot of M, relative to the sum of the weights, below which a term depends on the previous ones
DROPPED = 1e100  # pivot of a dropped term


@pointwise
def _basis(terms, x, y, z, p):
    p[0], p[1], p[2], p[3] = 1.0, x, y, z
    if terms == QUADRATIC:
        p[4], p[5], p[6], p[7], p[8], p[9] = x * x, y * y, z * z, y * z, x * z, x * y


@pointwise
def _factor(m, A, drops):
    """Overwrite the lower part of the first m rows and columns of a symmetric matrix A by its Cholesky factor; return False if
    it does not exist, otherwise True.

    drops: True to drop terms of the basis that depend on previous ones, e.g. if all nodes with a weight lie in a plane.
    """
    least = SINGULAR * A[0, 0]
    for i in range(m):
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            if i > j:
                A[i, j] = total / A[j, j]
            elif total > least:
                A[i, i] = total**0.5
            elif drops and i > 0:
                A[i, i] = DROPPED
            else:
                return False
    return True


@pointwise
def _solve(m, A, b):
    """Overwrite b (m,) with the solution A⁻¹ b; A: Cholesky factor computed by `_factor`."""
    for i in range(m):
        for k in range(i):
            b[i] -= A[i, k] * b[k]
        b[i] /= A[i, i]
    for i in range(m - 1, -1, -1):
        for k in range(i + 1, m):
            b[i] -= A[k, i] * b[k]
        b[i] /= A[i, i]


@pointwise
def _fill_moments(m, flat, n, scratch):
    """Fill `scratch.moments` with the moment matrix M = Σ w p ⊗ p and its derivatives along x, y, z.

    m: number of terms of the basis p; flat: True in two dimensions; n: number of nodes. Weights w, their gradients and the
    vectors x_a - x are read from `scratch`.
    """
    moments, offset, basis = scratch.moments, scratch.offset, scratch.terms[0]
    moments[:, :m, :m] = 0.0
    for i in range(n):
        weight = scratch.log_prior[i]
        if weight == 0.0:
            continue
        _basis(m, offset[i, 0], offset[i, 1], offset[i, 2], basis)
        for r in range(m):
            for s in range(r + 1):
                product = basis[r] * basis[s]
                moments[0, r, s] += weight * product
                for d in range(3):
                    moments[1 + d, r, s] += scratch.slope[i, d] * product
    for r in range(4, m):
        for k in range(4):
            moments[k, r, r] += PENALTY * moments[k, 0, 0]
    if flat:  # terms with z are zero
        moments[0, 3, 3] = moments[0, 0, 0]
        for r in range(6, m - 1):
            moments[0, r, r] = moments[0, 0, 0]


@pointwise
def least_squares(m, flat, drops, length, scratch, values, gradients):
    """Fill `values` (n,) with the shape functions of n nodes at a point x and `gradients` (3, n) with their gradients [1/m] for
    a basis of m terms; return `OK` or a code of `FAILURES`.

    flat: True in two dimensions; drops: see `_factor`; length: unit of length [m] of `scratch`, which contains the vectors
    x_a - x in `offset`, the weights of the nodes x_a in `log_prior` and their gradients in `slope`.
    """
    n, moments, offset = len(values), scratch.moments, scratch.offset
    _fill_moments(m, flat, n, scratch)
    if not _factor(m, moments[0], drops):
        return SINGULAR_MOMENTS
    basis, c, by = scratch.terms[0], scratch.terms[1], scratch.terms[2:]
    scratch.terms[1:, :] = 0.0
    c[0] = 1.0
    _solve(m, moments[0], c)
    wanted = gradients.shape[1] > 0
    if wanted:
        for j in range(3):
            by[j, 1 + j] = 1.0
            for r in range(m):
                for s in range(m):
                    by[j, r] -= moments[1 + j, max(r, s), min(r, s)] * c[s]
            _solve(m, moments[0], by[j])
    for i in range(n):
        _basis(m, offset[i, 0], offset[i, 1], offset[i, 2], basis)
        weight = scratch.log_prior[i]
        total = 0.0
        for r in range(m):
            total += c[r] * basis[r]
        values[i] = weight * total
        if wanted:
            for j in range(3):
                change = 0.0
                for r in range(m):
                    change += by[j, r] * basis[r]
                gradients[j, i] = (weight * change + scratch.slope[i, j] * total) / length
    _add_up_to_one(values, gradients)
    return OK


@pointwise
def _add_up_to_one(values, gradients):
    """Divide the shape functions of the nodes at a point by their sum, and correct their gradients accordingly, in place.

    The sum differs from one by the rounding of the moments; the difference would add momentum to a body. values: the
    functions, shape (n,); gradients: shape (3, n).
    """
    total = 0.0
    for i in range(len(values)):
        total += values[i]
    for i in range(len(values)):
        values[i] /= total
    if gradients.shape[1] > 0:
        for j in range(3):
            change = 0.0
            for i in range(len(values)):
                change += gradients[j, i]
            for i in range(len(values)):
                gradients[j, i] = (gradients[j, i] - values[i] * change) / total


class MovingLeastSquares(NamedTuple):
    """Parameters of the shape functions: nodes, radii of their supports, and distances from faces on which shape functions
    vanish (most nodes have no such faces)."""

    terms: int  # number of terms of the basis: 4 linear, 10 quadratic
    position: np.ndarray  # (n, 3) node positions [m]
    radius: np.ndarray  # (n,) radius of the support of each node [m]
    distances: FaceDistances  # in units of the mean edge length at a node


class LeastSquaresModel(FacedApproximant):
    """Base of the moving least squares approximants."""

    terms: ClassVar[int]
    """Number of terms of the basis in three dimensions."""
    reach: ClassVar[str | None] = "dilatation"
    remedy: ClassVar[str | None] = "increase it, so that supports have more neighbours, or use a different approximant"

    dilatation: float = parameter("", "radius of a support divided by the mean edge length at its node", 1.6, gt=1, le=5)

    @property
    def nodes_in_a_cell(self) -> float:
        return 88.0 * (self.dilatation / 1.6) ** 3  # measured at 1.6

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        """Build the shape functions for a mesh, with weights that are quartic splines of the distance from the node."""
        from pellucid.approximants.nodal.rings import nodes_in_reach  # scipy is slow to import

        radius = self.dilatation * mesh.spacing
        distances = face_distances(mesh, SHAPE, mesh.spacing, no_faces(len(mesh.nodes)))
        functions = MovingLeastSquares(self.terms, mesh.nodes, radius, distances)
        return Evaluator(nodes_in_reach(mesh, radius), functions, positive=False)


class MovingLeastSquaresModel(LeastSquaresModel):
    """Moving least squares with a linear basis."""

    terms: ClassVar[int] = LINEAR

    kind: Literal["moving-least-squares"] = "moving-least-squares"


class ModifiedMovingLeastSquaresModel(LeastSquaresModel):
    """Modified moving least squares: a quadratic basis with a small penalty on the quadratic coefficients."""

    terms: ClassVar[int] = QUADRATIC

    kind: Literal["modified-moving-least-squares"] = "modified-moving-least-squares"


@pointwise
def _weigh(fn, x, active, scratch, length):
    """Store the quartic weights of the active nodes at x [m], and their gradients times `length` [m], in `scratch`. Return True
    if a weight is zero because x lies on a face of prescribed displacement.

    fn: `MovingLeastSquares`; active: numbers of the n active nodes.
    """
    offset, distances, taken = scratch.offset, fn.distances, False
    for i in range(len(active)):
        a = active[i]
        square = 0.0
        for d in range(3):
            offset[i, d] = (fn.position[a, d] - x[d]) / length
            square += offset[i, d] * offset[i, d]
        ratio = length / fn.radius[a]
        q = square**0.5 * ratio
        rest = max(1.0 - q, 0.0)
        weight, steep = rest * rest * rest * (1.0 + 3.0 * q), 12.0 * rest * rest * ratio * ratio
        share, gx, gy, gz = 1.0, 0.0, 0.0, 0.0
        if distances.first[a] < distances.first[a + 1]:
            share, gx, gy, gz = share_before_faces(distances, x, a, scratch.faces)
            taken = taken or share == 0.0
        by = weight * length / distances.size[a]
        scratch.log_prior[i] = share * weight
        scratch.slope[i, 0] = share * steep * offset[i, 0] + by * gx
        scratch.slope[i, 1] = share * steep * offset[i, 1] + by * gy
        scratch.slope[i, 2] = share * steep * offset[i, 2] + by * gz
    return taken


@point_function(shape_functions, MovingLeastSquares)
def _moving_least_squares_functions(functions, cell, x, active, scratch, values, gradients):
    length = functions.radius[active[0]]
    taken = _weigh(functions, x, active, scratch, length)
    return least_squares(functions.terms, functions.distances.flat, taken, length, scratch, values, gradients)


class CellLeastSquares(NamedTuple):
    """Parameters of cell-based least-squares shape functions for kernels. The weight of a node depends on the distance from
    the faces that bound the ring of cells around the node."""

    smoothness: float  # exponent s of the weights
    position: np.ndarray  # (n, 3) node positions [m]
    distances: FaceDistances  # faces that bound the ring of cells around each node


class CellLeastSquaresModel(FacedApproximant):
    """Least squares with a quadratic basis and supports of rings of cells.

    The weights are the priors of cell-based maximum entropy (Millán, Sukumar & Arroyo 2015, Comput. Methods Appl. Mech. Eng.
    284, 712). The corners of a cell have positive weights everywhere in it, so that shape functions exist in every cell with a
    volume.
    """

    kind: Literal["cell-based-least-squares"] = "cell-based-least-squares"
    rings: int = parameter("", "size of a node's support: number of rings of cells around it", 2, ge=2, le=3)
    smoothness: float = parameter(
        "", "exponent s: the weight of a node is the distance to the edge of its support to the power s", 2.0, ge=1, le=8
    )
    shape: float = parameter(
        "", "smoothing factor α of the distance function of a triangle, which has kinks for α = 0", 0.2, gt=0, le=8
    )

    @property
    def nodes_in_a_cell(self) -> float:
        return {2: 35.0, 3: 116.0}[self.rings]  # measured

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        from pellucid.approximants.nodal.rings import nodes_of_cells, ring_boundaries  # scipy is slow to import

        bounds, size = ring_boundaries(mesh, self.rings)
        distances = face_distances(mesh, self.shape, size, bounds)
        return Evaluator(nodes_of_cells(mesh, self.rings), CellLeastSquares(self.smoothness, mesh.nodes, distances), False)


@pointwise
def _weight(fn, x, a, faces):
    """Return the weight D^s of node a at x [m], and the gradient of this weight times the size of the ring of cells around
    the node. D is the smooth distance of x from the faces that bound the ring, divided by the ring size.

    fn: `CellLeastSquares`, with the exponent s; faces: scratch memory for a block of faces.
    """
    total, gx, gy, gz = inverse_square(fn.distances, x, a, faces)
    if total == 0.0:  # the ring covers the whole mesh
        return 1.0, 0.0, 0.0, 0.0
    if total * VANISHING * VANISHING >= 1.0:
        return 0.0, 0.0, 0.0, 0.0
    weight = total ** (-0.5 * fn.smoothness)
    factor = weight * fn.smoothness / total
    return weight, factor * gx, factor * gy, factor * gz


@point_function(shape_functions, CellLeastSquares)
def _cell_least_squares_functions(functions, cell, x, active, scratch, values, gradients):
    distances = functions.distances
    length = distances.size[active[0]]
    for i in range(len(active)):
        a = active[i]
        weight, gx, gy, gz = _weight(functions, x, a, scratch.faces)
        factor = length / distances.size[a]
        scratch.log_prior[i] = weight
        scratch.slope[i, 0], scratch.slope[i, 1], scratch.slope[i, 2] = factor * gx, factor * gy, factor * gz
        for d in range(3):
            scratch.offset[i, d] = (functions.position[a, d] - x[d]) / length
    return least_squares(QUADRATIC, distances.flat, True, length, scratch, values, gradients)
