"""Factorisation of symmetric matrices by nested dissection."""

import numpy as np
import pytest
from scipy import sparse

from pellucid.linear.elimination import Elimination, Factor, factor_size

N = 9  # nodes along an edge of the cube


def cube() -> tuple[np.ndarray, sparse.csr_array]:
    """Return places of the nodes of a cube, shape (n, 3), and the matrix that links neighbours."""
    places = np.stack(np.meshgrid(*3 * [np.arange(N, dtype=float)], indexing="ij"), axis=-1).reshape(-1, 3)
    line = sparse.diags_array([np.ones(N - 1), np.ones(N), np.ones(N - 1)], offsets=[-1, 0, 1])
    return places, sparse.csr_array(sparse.kron(sparse.kron(line, line), line))


def matrix(d: int, negative: int) -> tuple[np.ndarray, sparse.csr_array, sparse.csr_array]:
    """Return places, links and a symmetric matrix with d unknowns per node, of which the last `negative` have the sign of
    pressures: [K Bᵀ; B -C] with K and C dominated by their diagonals, and any B."""
    places, links = cube()
    rng = np.random.default_rng(1)
    pattern = sparse.csr_array(sparse.kron(links, np.ones((d, d))))
    whole = pattern.copy()
    whole.data = rng.standard_normal(len(whole.data))
    whole = sparse.csr_array(whole + whole.T)
    row, column = np.repeat(np.arange(whole.shape[0]), np.diff(whole.indptr)) % d, whole.indices % d
    minus_row, minus_column = row >= d - negative, column >= d - negative
    whole.data[minus_row & minus_column] *= -0.1
    diagonal = np.where(np.arange(whole.shape[0]) % d < d - negative, 1.0, -1.0) * 30.0 * d
    return places, links, sparse.csr_array(whole + sparse.diags_array(diagonal))


@pytest.mark.parametrize(("d", "negative"), [(1, 0), (3, 0), (4, 1), (3, 2)])
@pytest.mark.parametrize("precision", [np.float32, np.float64])
def test_solves(d: int, negative: int, precision: type) -> None:
    places, links, A = matrix(d, negative)
    A.sort_indices()
    factor = Factor(Elimination(links, places, A.indptr, A.indices, d, negative), A.data, precision)
    right = np.random.default_rng(2).standard_normal(A.shape[0])
    error = np.linalg.norm(A @ factor.solve(right) - right) / np.linalg.norm(right)
    assert error < 100.0 * np.finfo(precision).eps  # a condition number of some tens


def test_the_size_of_the_factors_is_known_before() -> None:
    places, links, A = matrix(4, 1)
    A.sort_indices()
    factor = Factor(Elimination(links, places, A.indptr, A.indices, 4, 1), A.data, np.float64)
    numbers = sum(0.5 * diagonal.size + below.size for diagonal, below in factor._panels)
    assert factor_size(links, places, 4).numbers == pytest.approx(numbers, rel=1e-12)


def test_refuses_matrices_of_another_kind() -> None:
    """A pivot of the wrong sign is refused in both parts of the matrix, so that instabilities are found."""
    for d, negative, wrong in ((3, 0, 0), (4, 1, 1), (4, 1, 3)):
        places, links, A = matrix(d, negative)
        shift = np.zeros(A.shape[0])
        shift[d * 100 + wrong] = 1e3 if wrong >= d - negative else -1e3
        A = sparse.csr_array(A + sparse.diags_array(shift))
        A.sort_indices()
        with pytest.raises(np.linalg.LinAlgError):
            Factor(Elimination(links, places, A.indptr, A.indices, d, negative), A.data, np.float64)
