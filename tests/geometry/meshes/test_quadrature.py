"""Quadrature on tetrahedra: weights, places, exactness."""

from math import factorial

import numpy as np
import pytest

from pellucid.geometry.meshes.quadrature import TETRAHEDRON

EXACT_DEGREE = {1: 1, 4: 2, 8: 1, 16: 2, 32: 2}


@pytest.mark.parametrize("points", TETRAHEDRON)
def test_points_lie_within_and_shares_add_up(points):
    shares = TETRAHEDRON[points]
    assert shares.shape == (points, 4)
    assert shares.min() > 0.0
    assert shares.sum(axis=1) == pytest.approx(1.0, abs=1e-14)
    assert len(np.unique(shares.round(12), axis=0)) == points


@pytest.mark.parametrize("points", TETRAHEDRON)
def test_polynomials_are_integrated_exactly_up_to_its_degree(points):
    """∫ a^i b^j c^k d^l over a tetrahedron is 3! i! j! k! l!/(i + j + k + l + 3)! of its volume."""
    shares, errors = TETRAHEDRON[points], {}
    for degree in range(4):
        for powers in np.ndindex(degree + 1, degree + 1, degree + 1, degree + 1):
            if sum(powers) == degree:
                exact = 6.0 * np.prod([factorial(p) for p in powers]) / factorial(degree + 3)
                error = abs(np.prod(shares ** np.array(powers), axis=1).mean() - exact)
                errors[degree] = max(errors.get(degree, 0.0), error)
    assert max(errors[d] for d in range(EXACT_DEGREE[points] + 1)) < 1e-15
    assert errors[EXACT_DEGREE[points] + 1] > 1e-4, "and no further"


@pytest.mark.parametrize(("coarse", "fine"), [(1, 8), (4, 16), (4, 32)])
def test_subdivision_brings_a_smooth_integral_closer(coarse, fine):
    corners = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
    value = {n: np.exp(TETRAHEDRON[n] @ corners @ (1.0, 2.0, -1.0)).mean() for n in (coarse, fine)}
    reference = _reference(corners)
    assert abs(value[fine] - reference) < abs(value[coarse] - reference)


def _reference(corners):
    """The mean of exp(x + 2y - z) over the tetrahedron: 3! times the divided difference of exp at the values at its corners
    (Hermite & Genocchi)."""
    at = corners @ (1.0, 2.0, -1.0)
    return 6.0 * sum(np.exp(at[i]) / np.prod([at[i] - at[j] for j in range(4) if j != i]) for i in range(4))
