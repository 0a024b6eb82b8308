"""Factorisation of symmetric matrices that are not definite."""

import numpy as np
import pytest
from linear.test_elimination import matrix
from scipy import sparse

from pellucid.linear.elimination import Elimination
from pellucid.linear.indefinite import IndefiniteFactor


@pytest.mark.parametrize("lowered", [0.0, 60.0, 90.0])
def test_solves_and_counts_negative_eigenvalues(lowered):
    """With this much subtracted from the diagonal, none, few or most of the eigenvalues are negative."""
    places, links, A = matrix(3, 0)
    A = sparse.csr_array(A - sparse.diags_array(np.full(A.shape[0], lowered)))
    A.sort_indices()
    factor = IndefiniteFactor(A, Elimination(links, places, A.indptr, A.indices, 3).order)
    assert factor.negative == np.count_nonzero(np.linalg.eigvalsh(A.toarray()) < 0.0)
    right = np.random.default_rng(2).standard_normal(A.shape[0])
    assert np.linalg.norm(A @ factor.solve(right) - right) < 1e-10 * np.linalg.norm(right)


def test_pivots_belong_to_their_unknowns():
    """The pivots of a diagonal matrix are its entries."""
    entries = np.random.default_rng(3).standard_normal(50)
    factor = IndefiniteFactor(sparse.csr_array(sparse.diags_array(entries)), np.random.default_rng(4).permutation(50))
    assert np.allclose(factor.pivots(), abs(entries), rtol=1e-15)
    assert factor.negative == np.count_nonzero(entries < 0.0)


def test_a_singular_matrix_is_refused():
    with pytest.raises(np.linalg.LinAlgError):
        IndefiniteFactor(sparse.csr_array(np.diag([1.0, 0.0, 2.0])), np.arange(3))
