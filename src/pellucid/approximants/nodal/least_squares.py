"""Moving least squares with polynomials: shape functions from nodal weights and their gradients.

A node at x_a with the weight w_a has the shape function p_a = w_a p(x - x_a)·M⁻¹ p(0) with M = Σ_a w_a p ⊗ p. The basis p
is linear, or quadratic with a small penalty on its quadratic coefficients, which keeps M regular wherever the linear terms
are (Joldes et al. 2015, Appl. Math. Comput. 266, 893).
"""

from pellucid.approximants.nodal.contract import OK, SINGULAR_MOMENTS
from pellucid.jit import pointwise

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
