"""Eigenvalues and isotropic functions of symmetric tensors, above all where eigenvalues are equal or nearly so."""

from math import nan

import numpy as np
import pytest
from algebra import eigen, matrix, rotation, symmetric

from pellucid.materials.principal import isotropic_deviator, spectrum

VALUES = {
    "apart": (3.0, 0.2, 1.1),
    "equal": (1.0, 1.0, 1.0),
    "an upper pair": (0.5, 2.0, 2.0),
    "a lower pair": (2.0, 0.5, 0.5),
    "nearly equal": (1.0, 1.0 + 1e-12, 1.0 - 3e-13),
    "a near pair": (2.0, 0.5, 0.5 + 1e-9),
    "equal distances": (1.0, 2.0, 3.0),
    "far apart": (1e4, 1.0, 1e-4),
    "small": (3e-20, 1e-20, 2e-20),
}
every_value = pytest.mark.parametrize("values", VALUES.values(), ids=VALUES)
every_seed = pytest.mark.parametrize("seed", range(4))


def turned(values, seed):
    Q = rotation(seed)
    return symmetric(Q @ np.diag(values) @ Q.T)


def deviator(m):
    return np.array(m - np.trace(m) / 3.0 * np.eye(3), float)


@every_value
@every_seed
def test_eigenvalues_are_right_to_rounding(values, seed):
    a = turned(values, seed)
    found, scale = spectrum(a), max(values)
    x = found.values
    assert sorted(x) == pytest.approx(np.sort(eigen(matrix(a))[0]).astype(float), abs=4e-15 * scale)
    assert x[1] - x[2] == pytest.approx(found.distance, abs=1e-15 * scale)
    assert found.first == pytest.approx(x[0] - sum(values) / 3.0, abs=4e-15 * scale)
    assert found.across == pytest.approx((x[0] - x[1], x[0] - x[2]), abs=1e-14 * scale)


@every_value
@every_seed
def test_the_first_lies_apart(values, seed):
    found = spectrum(turned(values, seed))
    one, other = found.across
    assert one * other > 0.0
    assert min(abs(one), abs(other)) >= 0.99 * found.distance >= 0.0


@every_value
@every_seed
def test_isotropic_functions_need_no_eigenvectors(values, seed):
    """The deviator of the square and of the inverse, whose differences have factors x - y."""
    a = turned(values, seed)
    found, m = spectrum(a), matrix(a).astype(np.longdouble)
    x, y, z = found.values
    square = isotropic_deviator(found, (x - y) * (x + y), y + z)
    assert matrix(square) == pytest.approx(deviator(m @ m), abs=4e-15 * max(values) ** 2)
    if max(values) < 1e3 * min(values):
        inverse = isotropic_deviator(found, (y - x) / (x * y), -1.0 / (y * z))
        own, Q = eigen(m)
        condition = max(values) / min(values)
        assert matrix(inverse) == pytest.approx(deviator(Q / own @ Q.T), abs=4e-15 * condition / min(values))


def test_equal_eigenvalues_are_equal_to_the_last_digit():
    """At rest there is no energy at all."""
    found = spectrum((1.0, 1.0, 1.0, 0.0, 0.0, 0.0))
    assert found.values == (1.0, 1.0, 1.0)
    assert isotropic_deviator(found, 0.0, 1.0) == (0.0,) * 6


def test_a_tensor_along_the_axes_has_a_deviator_along_them():
    found = spectrum((3.0, 0.2, 1.1, 0.0, 0.0, 0.0))
    assert sorted(found.values) == pytest.approx((0.2, 1.1, 3.0), rel=1e-15)
    assert isotropic_deviator(found, found.across[0], 1.0)[3:] == (0.0, 0.0, 0.0)


@pytest.mark.parametrize("place", range(6))
def test_what_is_not_a_number_stays_so(place):
    a = [1.0, 2.0, 3.0, 0.1, 0.2, 0.3]
    a[place] = nan
    found = spectrum(tuple(a))
    assert np.isnan(found.values).all()
    assert np.isnan(isotropic_deviator(found, 1.0, 1.0)).all()
