"""Eigenvalues and eigenvectors of symmetric tensors, above all where eigenvalues are equal or nearly so."""

from math import nan

import numpy as np
import pytest
from algebra import matrix, rotation, symmetric

from pellucid.materials.principal import from_principal, principal

VALUES = {
    "apart": (3.0, 0.2, 1.1),
    "equal": (1.0, 1.0, 1.0),
    "a pair": (2.0, 0.5, 0.5),
    "nearly equal": (1.0, 1.0 + 1e-12, 1.0 - 3e-13),
    "a near pair": (2.0, 0.5, 0.5 + 1e-9),
    "far apart": (1e4, 1.0, 1e-4),
    "small": (3e-20, 1e-20, 2e-20),
    "negative": (-1.0, 2.0, -0.5),
}


@pytest.mark.parametrize("values", VALUES.values(), ids=VALUES)
@pytest.mark.parametrize("seed", range(4))
def test_what_numpy_finds(values, seed):
    Q = rotation(seed)
    a = symmetric(Q @ np.diag(values) @ Q.T)
    found, *vectors = principal(a)
    scale = max(map(abs, values))
    assert sorted(found) == pytest.approx(np.linalg.eigvalsh(matrix(a)), abs=4e-15 * scale)
    V = np.array(vectors)
    assert pytest.approx(np.eye(3), abs=1e-14) == V @ V.T
    assert matrix(from_principal(found, *vectors)) == pytest.approx(matrix(a), abs=4e-15 * scale)
    # a turn about one axis leaves entries that are 0 at once
    assert sorted(principal((*values, 0.0, 0.0, 0.0))[0]) == sorted(values)


def test_a_small_eigenvalue_keeps_its_digits():
    """Jacobi's rotations find small eigenvalues of a graded tensor to their own precision."""
    a = (1.0, 1e-8, 1e-16, 1e-13, 1e-9, 1e-5)
    exact = 1e-24 + 2 * 1e-13 * 1e-9 * 1e-5 - 1e-26 - 1e-8 * 1e-18 - 1e-16 * 1e-10
    assert np.prod(principal(a)[0]) == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize("place", range(6))
def test_what_is_not_a_number_stays_so(place):
    a = [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]
    a[place] = nan
    assert np.isnan(sum(principal(tuple(a))[0]))
