"""Moving least squares, and the modified form with a quadratic basis whose moment matrix stays regular.

Sources: Belytschko, Lu & Gu 1994, Int. J. Numer. Methods Eng. 37, 229; Joldes et al. 2015, Appl. Math. Comput. 266, 893.
"""

from typing import ClassVar, Literal, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import OK, SINGULAR_MOMENTS, Evaluator, NodalApproximant, shape_functions
from pellucid.geometry.simplex_mesh import SimplexMesh
from pellucid.jit import point_function, pointwise
from pellucid.model import parameter

PENALTY = 1e-7  # on quadratic coefficients, in lengths of the support and for weights of order one
SINGULAR = 1e-13  # pivot below which the moment matrix counts as singular, of its diagonal


class MovingLeastSquares(NamedTuple):
    """Nodes and their supports."""

    flat: bool
    terms: int  # of the basis: 4 linear, 10 quadratic
    position: np.ndarray  # (n, 3) [m]
    radius: np.ndarray  # (n,) of the supports [m]


class LeastSquaresModel(NodalApproximant):
    """What the approximants by moving least squares share."""

    terms: ClassVar[int]
    """Of the basis in space."""
    reach: ClassVar[str | None] = "dilatation"
    remedy: ClassVar[str] = "raise it, so that supports have more neighbours, or use another approximant"

    dilatation: float = parameter("", "radius of a support in mean lengths of the edges at its node", 1.6, gt=1, le=5)

    @property
    def interpolates(self) -> bool:
        """Never."""
        return False

    @property
    def nodes_in_a_cell(self) -> float:
        """Counted at a dilatation of 1.6."""
        return 88.0 * (self.dilatation / 1.6) ** 3

    def evaluator(self, mesh: SimplexMesh) -> Evaluator:
        """Functions with quartic weights."""
        from pellucid.approximants.nodal.rings import nodes_in_reach  # scipy is heavy

        radius = self.dilatation * mesh.spacing
        functions = MovingLeastSquares(mesh.dimension == 2, self.terms, mesh.nodes, radius)
        return Evaluator(nodes_in_reach(mesh, radius), functions, positive=False)


class MovingLeastSquaresModel(LeastSquaresModel):
    """Moving least squares with a linear basis."""

    terms: ClassVar[int] = 4

    kind: Literal["moving-least-squares"] = "moving-least-squares"


class ModifiedMovingLeastSquaresModel(LeastSquaresModel):
    """Modified moving least squares: a quadratic basis, with a small penalty on the quadratic coefficients."""

    terms: ClassVar[int] = 10

    kind: Literal["modified-moving-least-squares"] = "modified-moving-least-squares"


@pointwise
def _basis(terms, x, y, z, p):
    p[0], p[1], p[2], p[3] = 1.0, x, y, z
    if terms == 10:
        p[4], p[5], p[6], p[7], p[8], p[9] = x * x, y * y, z * z, y * z, x * z, x * y


@pointwise
def _factor(m, A):
    """Cholesky's factor of the first m rows and columns of A in its lower part; whether there is one."""
    for i in range(m):
        diagonal = A[i, i]
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            if i == j:
                if total <= SINGULAR * diagonal:
                    return False
                A[i, i] = total**0.5
            else:
                A[i, j] = total / A[j, j]
    return True


@pointwise
def _solve(m, A, b):
    """Overwrite b with A⁻¹ b, from Cholesky's factor."""
    for i in range(m):
        for k in range(i):
            b[i] -= A[i, k] * b[k]
        b[i] /= A[i, i]
    for i in range(m - 1, -1, -1):
        for k in range(i + 1, m):
            b[i] -= A[k, i] * b[k]
        b[i] /= A[i, i]


@pointwise
def _fill_moments(fn, x, active, scratch, length):
    """Σ w p ⊗ p and its derivatives, with weights in `log_prior` and their derivatives in `slope`, in lengths of a support."""
    m, moments, offset = fn.terms, scratch.moments, scratch.offset
    basis = scratch.terms[0]
    moments[:, :m, :m] = 0.0
    for i in range(len(active)):
        a = active[i]
        square = 0.0
        for d in range(3):
            offset[i, d] = (fn.position[a, d] - x[d]) / length
            square += offset[i, d] * offset[i, d]
        ratio = length / fn.radius[a]
        q = square**0.5 * ratio
        rest = max(1.0 - q, 0.0)
        weight = rest * rest * rest * (1.0 + 3.0 * q)
        steep = 12.0 * rest * rest * ratio * ratio if q < 1.0 else 0.0
        scratch.log_prior[i] = weight
        for d in range(3):
            scratch.slope[i, d] = steep * offset[i, d]
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
        moments[0, r, r] += PENALTY
    if fn.flat:  # terms with z are nothing but zeros
        moments[0, 3, 3] = 1.0
        for r in range(6, m - 1):
            moments[0, r, r] = 1.0


@pointwise
def _least_squares(fn, x, active, scratch, values, gradients):
    m, n, moments, offset = fn.terms, len(active), scratch.moments, scratch.offset
    length = fn.radius[active[0]]
    _fill_moments(fn, x, active, scratch, length)
    if not _factor(m, moments[0]):
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
    """Divide by the sum, which is one but for the rounding of the moments: what is left of it would give a body momentum."""
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


@point_function(shape_functions, MovingLeastSquares)
def _shape_functions(functions, cell, x, active, scratch, values, gradients):
    return _least_squares(functions, x, active, scratch, values, gradients)
