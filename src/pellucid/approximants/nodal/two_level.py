"""Two-level conjugate gradients for systems similar to a thin plate, whose null space is the affine functions of the nodes.

Smooth functions have little energy in such systems, proportional to the fourth power of their wave number: with a diagonal
preconditioner the number of iterations grows with the square of the number of nodes along an edge. A coarse space of
quadratic B-splines on a lattice, solved directly and added to the diagonal, resolves smooth functions (Toselli & Widlund
2005, Domain Decomposition Methods, section 2.5), so that the number of iterations does not depend on the number of nodes.
"""

from collections.abc import Callable

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from pellucid.findings import Refusal

COARSE = 4.0  # spacing of the lattice divided by the node spacing
MOST_FUNCTIONS = 4000  # largest number of functions of the lattice
LEAST_WEIGHT = 0.02  # functions with smaller values at all nodes are dropped
SHIFT = 1e-9  # fraction of the diagonal added to it, because of the affine functions
CLOSE, FAR = 1e-13, 1e-10  # relative residual at which to stop, and above which the solution has failed
PASS = 1e-8  # reduction of the residual after which it is recomputed
SLOW = 0.5  # reduction in a pass above which another pass is useless
PASSES, MOST_ITERATIONS = 6, 2000


def solve(matrix: sparse.csr_array, wanted: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """Return the solution x of matrix @ x = wanted, shape (n, k), by two-level conjugate gradients. The affine functions of
    the nodes are in the null space of the matrix, so x is determined up to an affine function.

    wanted: k right-hand sides, shape (n, k). nodes: positions of the nodes [m], shape (n, 3). Raises Refusal if the
    residual stays above 1e-10 of the right-hand side.
    """
    affine = _affine_functions(nodes)

    def without_affine(vector: np.ndarray) -> np.ndarray:
        return np.asarray(vector - np.einsum("ni,ik->nk", affine, np.einsum("ni,nk->ik", affine, vector)))

    precondition = _preconditioner(matrix, nodes)
    found, residual = np.zeros_like(wanted), without_affine(wanted)
    size = reached = np.linalg.norm(residual, axis=0)
    for _ in range(PASSES):
        found += _iterate(matrix, residual, lambda r: without_affine(precondition(r)), CLOSE * size)
        residual = without_affine(wanted - matrix @ found)
        before, reached = reached, np.linalg.norm(residual, axis=0)
        if (reached <= CLOSE * size).all() or (reached > SLOW * before).all():
            break
    if (reached > FAR * size).any():
        text = "the correction of gradients for consistent quadrature did not converge: the relative residual is"
        text = f"{text} {float((reached / size).max()):.1e}, and must be at most {FAR:g}"
        raise Refusal(text, "improve the flattest tetrahedra of the mesh, or set `consistent = false`")
    return found


def _affine_functions(nodes: np.ndarray) -> np.ndarray:
    """Return an orthonormal basis of the affine functions 1, x, y, z by its values at the nodes, shape (n, 4).

    nodes: positions, shape (n, 3) [m]. Sums are computed without libraries whose results depend on the number of threads.
    """
    centred = nodes - nodes.mean(axis=0)
    root = np.linalg.cholesky(np.einsum("ni,nj->ij", centred, centred))
    constant = np.full((len(nodes), 1), len(nodes) ** -0.5)
    return np.hstack([constant, np.einsum("ni,ji->nj", centred, np.linalg.inv(root))])


Operator = Callable[[np.ndarray], np.ndarray]


def _iterate(matrix: sparse.csr_array, wanted: np.ndarray, precondition: Operator, close: np.ndarray) -> np.ndarray:
    """Return the approximate solution of matrix @ x = wanted by conjugate gradients that start from zero, with separate step
    lengths for each column of `wanted`, shape (n, k).

    precondition: function that applies the preconditioner to residuals, shape (n, k); close: norm of the residual of each
    column at which to stop, shape (k,).
    """
    x, residual = np.zeros_like(wanted), wanted.copy()
    z = precondition(residual)
    direction, product = z, np.sum(residual * z, axis=0)
    enough = np.maximum(close, PASS * np.linalg.norm(residual, axis=0))
    for _ in range(MOST_ITERATIONS):
        if (np.linalg.norm(residual, axis=0) <= enough).all():
            break
        image = matrix @ direction
        energy = np.sum(direction * image, axis=0)
        step = np.divide(product, energy, out=np.zeros_like(energy), where=energy > 0.0)
        x += step * direction
        residual -= step * image
        z, before = precondition(residual), product
        product = np.sum(residual * z, axis=0)
        direction = z + np.divide(product, before, out=np.zeros_like(before), where=before > 0.0) * direction
    return x


def _preconditioner(matrix: sparse.csr_array, nodes: np.ndarray) -> Operator:
    diagonal = matrix.diagonal()[:, None]
    smooth = _lattice_functions(nodes)
    coarse = sparse.csc_array(smooth.T @ (matrix @ smooth))
    shift = SHIFT * np.maximum(coarse.diagonal(), coarse.diagonal().mean())
    factor = splu(coarse + sparse.diags_array(shift, format="csc"), options={"SymmetricMode": True}, permc_spec="MMD_AT_PLUS_A")
    over = np.divide(1.0, diagonal, out=np.zeros_like(diagonal), where=diagonal > 1e-12 * diagonal.max())
    return lambda r: over * r + smooth @ factor.solve(smooth.T @ r)


def _lattice_functions(nodes: np.ndarray) -> sparse.csr_array:
    """Return the values, at nodes with the positions `nodes`, shape (n, 3) [m], of the quadratic B-splines on a coarse lattice,
    as a sparse matrix of shape (n, functions)."""
    low, extent = nodes.min(axis=0), np.ptp(nodes, axis=0)
    spacing = COARSE * float(np.cbrt(np.prod(extent) / len(nodes)))
    while True:
        functions = _functions_of(np.maximum(nodes - low, 0.0) / spacing)
        if functions.shape[1] <= MOST_FUNCTIONS:
            return functions
        spacing *= 1.2


def _functions_of(place: np.ndarray) -> sparse.csr_array:
    """Return the values of the quadratic B-splines of a lattice at n positions, shape (n, 3), in units of its spacing from its
    lower corner, as a matrix of shape (n, functions). Functions that are small at all positions are left out."""
    n, whole = len(place), np.floor(place).astype(np.int64)
    part = place - whole
    axes = np.stack([0.5 * (1.0 - part) ** 2, 0.5 + part * (1.0 - part), 0.5 * part**2], axis=-1)
    counts = whole.max(axis=0) + 3
    number = whole[:, :, None] + np.arange(3)
    columns = (number[:, 0, :, None, None] * counts[1] + number[:, 1, None, :, None]) * counts[2] + number[:, 2, None, None, :]
    values = np.einsum("ni,nj,nk->nijk", *axes.swapaxes(0, 1)).ravel()
    rows, columns = np.repeat(np.arange(n), 27), columns.ravel()
    largest = np.zeros(int(np.prod(counts)))
    np.maximum.at(largest, columns, values)
    kept = largest >= LEAST_WEIGHT
    renumbered, chosen = np.cumsum(kept) - 1, kept[columns]
    entries = values[chosen], (rows[chosen], renumbered[columns[chosen]])
    return sparse.csr_array(entries, shape=(n, int(kept.sum())))
