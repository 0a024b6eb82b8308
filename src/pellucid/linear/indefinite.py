"""Factorisation of sparse symmetric matrices that need not be definite, such as the stiffness of a body at an unstable
equilibrium.

The matrix is factored without interchanges of rows in the order of a nested dissection, A = L D Lᵀ, by SuperLU (Demmel et al.
1999, SIAM J. Matrix Anal. Appl. 20, 720). D then has as many negative entries as A has negative eigenvalues (Sylvester's law
of inertia). Growth of rounding errors, which pivoting would prevent, is removed by a step of iterative refinement in each
solution.
"""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from pellucid.linear.elimination import on_one_thread


class IndefiniteFactor:
    """The factors of a symmetric matrix.

    matrix: the matrix, shape (n, n); order: numbers of the unknowns in the order of elimination, shape (n,). Raises LinAlgError
    if the matrix is singular.
    """

    def __init__(self, matrix: sparse.csr_array, order: np.ndarray) -> None:
        self._matrix, self._order = matrix, order
        permuted = sparse.csc_array(matrix[order][:, order])
        with on_one_thread():
            try:
                self._factors = splu(permuted, "NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})
            except RuntimeError:
                raise np.linalg.LinAlgError("the matrix is singular") from None
        pivots, place = self._factors.U.diagonal(), self._factors.perm_c
        if not np.array_equal(self._factors.perm_r, place) or not np.isfinite(pivots).all():
            raise np.linalg.LinAlgError("a pivot vanishes")
        self._pivots = np.empty_like(pivots)
        self._pivots[order] = pivots[place]
        self.negative = int(np.count_nonzero(pivots < 0.0))
        """Number of negative eigenvalues of the matrix."""

    def pivots(self) -> np.ndarray:
        """Return the absolute pivots of the unknowns, shape (n,)."""
        return np.abs(self._pivots)

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Return the solution of the linear system for the right-hand side `right`, shape (n,)."""
        found = self._solved(right)
        return found + self._solved(right - self._matrix @ found)

    def _solved(self, right: np.ndarray) -> np.ndarray:
        found = np.empty_like(right)
        with on_one_thread():
            found[self._order] = self._factors.solve(right[self._order])
        return found
