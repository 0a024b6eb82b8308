"""Pointwise algebra against numpy."""

import numpy as np
import pytest
from algebra import matrix

from pellucid.tensors import (
    IDENTITY,
    NO_STRESS,
    SYMMETRIC_IDENTITY,
    add,
    cofactor,
    deformed,
    determinant,
    deviator,
    double_dot,
    full,
    largest_row_sum,
    left_cauchy_green,
    multiply,
    piola_transform,
    rotate,
    scale,
    spin_rotation,
    symmetric_part,
    trace,
)

ROUNDING = 1e-13  # a few products of numbers of order one
SKEW = (0.0, -0.3, 0.2, 0.3, 0.0, -0.7, -0.2, 0.7, 0.0)  # the gradient of w × x for w = (0.7, 0.2, 0.3)
SPIN = np.array([0.7, 0.2, 0.3])


@pytest.fixture(params=range(5))
def pair(request):
    """Return two random tensors as 9-tuples."""
    numbers = np.random.default_rng(request.param).uniform(-1.0, 1.0, (2, 9))
    return tuple(numbers[0].tolist()), tuple(numbers[1].tolist())


def test_products_and_parts(pair):
    A, B = pair
    a, b = matrix(A), matrix(B)
    assert matrix(multiply(A, B)) == pytest.approx(a @ b, abs=ROUNDING)
    assert determinant(A) == pytest.approx(np.linalg.det(a), abs=ROUNDING)
    assert matrix(symmetric_part(A)) == pytest.approx(0.5 * (a + a.T), abs=ROUNDING)
    assert matrix(left_cauchy_green(A)) == pytest.approx(a @ a.T, abs=ROUNDING)
    assert matrix(deformed(A, 0.1, B)) == pytest.approx((np.eye(3) + 0.1 * a) @ b, abs=ROUNDING)
    s, t = symmetric_part(A), symmetric_part(B)
    assert double_dot(s, t) == pytest.approx(np.sum(matrix(s) * matrix(t)), abs=ROUNDING)


def test_symmetric_tensors(pair):
    s, t = symmetric_part(pair[0]), symmetric_part(pair[1])
    a = matrix(s)
    assert matrix(full(s)) == pytest.approx(a, abs=0.0)
    assert matrix(add(s, t)) == pytest.approx(a + matrix(t), abs=ROUNDING)
    assert matrix(scale(-3.0, s)) == pytest.approx(-3.0 * a, abs=ROUNDING)
    assert trace(s) == pytest.approx(np.trace(a), abs=ROUNDING)
    assert matrix(deviator(s)) == pytest.approx(a - np.trace(a) / 3.0 * np.eye(3), abs=ROUNDING)
    assert np.array_equal(matrix(IDENTITY), np.eye(3))
    assert full(SYMMETRIC_IDENTITY) == IDENTITY
    assert not np.any(matrix(NO_STRESS))


def test_cofactor_and_piola_transform(pair):
    """cof A = det(A) A⁻ᵀ, P = J σ F⁻ᵀ."""
    A, s = pair[0], symmetric_part(pair[1])
    inverse = np.linalg.inv(matrix(A)).T
    # an inverse loses what the condition of A costs, here at most 1e2
    assert matrix(cofactor(A)) == pytest.approx(determinant(A) * inverse, abs=1e2 * ROUNDING)
    assert matrix(piola_transform(s, A)) == pytest.approx(determinant(A) * matrix(s) @ inverse, abs=1e2 * ROUNDING)
    assert matrix(cofactor((1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0))) == pytest.approx(np.diag([0.0, 2.0, 0.0]))


def test_rotated_tensors(pair):
    Q = spin_rotation(pair[0], 1.0)
    s = symmetric_part(pair[1])
    assert matrix(rotate(Q, s)) == pytest.approx(matrix(Q) @ matrix(s) @ matrix(Q).T, abs=ROUNDING)


@pytest.mark.parametrize("dt", [1e-9, 1e-3, 1.0, 100.0, 1e8])
def test_spin_rotation_is_orthogonal_for_every_step(pair, dt):
    Q = matrix(spin_rotation(pair[0], dt))
    assert np.abs(Q @ Q.T - np.eye(3)).max() < ROUNDING
    assert np.linalg.det(Q) == pytest.approx(1.0, abs=ROUNDING)


@pytest.mark.parametrize("dt", [0.01, 0.5, 3.0])
def test_spin_rotation_turns_about_the_axis_by_the_stated_angle(dt):
    """Half the tangent's angle is exact: tan(angle/2) = |w| dt/2."""
    Q = matrix(spin_rotation(SKEW, dt))
    assert np.abs(Q @ SPIN - SPIN).max() < ROUNDING
    across = np.cross(SPIN, [1.0, 0.0, 0.0])
    across /= np.linalg.norm(across)
    turned = Q @ across
    angle = 2.0 * np.arctan(0.5 * dt * np.linalg.norm(SPIN))
    assert across @ turned == pytest.approx(np.cos(angle), abs=ROUNDING)
    # the sense: right-handed about w
    assert np.cross(across, turned) @ SPIN == pytest.approx(np.sin(angle) * np.linalg.norm(SPIN), abs=ROUNDING)


def test_stretching_does_not_turn():
    stretch = (0.3, 0.1, 0.2, 0.1, -0.4, 0.5, 0.2, 0.5, 0.6)
    assert matrix(spin_rotation(stretch, 1.0)) == pytest.approx(np.eye(3), abs=ROUNDING)


def test_largest_row_sum_bounds_the_largest_eigenvalue(pair):
    s = symmetric_part(pair[0])
    assert largest_row_sum(s) >= np.linalg.eigvalsh(matrix(s)).max() - ROUNDING
    assert largest_row_sum((0.3, 0.9, -2.0, 0.0, 0.0, 0.0)) == 0.9
