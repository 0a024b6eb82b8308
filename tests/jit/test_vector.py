"""Vectors of eight doubles in kernels, against plain arrays."""

import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.vector import LANES, load, splat, store, total


@kernel()
def combined(a, b, out):
    x, y = load(a, 0), load(b, LANES)
    z = 2.0 * x - y * x + splat(0.5)
    z += y
    store(out, 0, z)
    return total(z)


@pytest.mark.parametrize("precision", [np.float64, np.float32])
def test_arithmetic_is_that_of_arrays(precision):
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=LANES).astype(precision), rng.normal(size=2 * LANES)
    out = np.zeros(LANES)
    found = combined(a, b, out)
    x, y = a.astype(float), b[LANES:]
    expected = 2.0 * x - y * x + 0.5 + y
    assert out == pytest.approx(expected, rel=1e-15, abs=1e-15)  # a product and a sum may round once
    assert found == pytest.approx(expected.sum(), abs=1e-14)


def test_the_lanes_are_added_in_a_fixed_order():
    lanes = np.array([1e16, 1.0, 1.0, 1.0, -1e16, 1.0, 1.0, 1.0])
    out = np.zeros(LANES)
    # halves first: (1e16 - 1e16) + 2 + 2 + 2, where from the first lane on six ones would be lost
    assert combined(lanes * 0.0, np.concatenate([lanes * 0.0, lanes - 0.5]), out) == pytest.approx(6.0, abs=1e-9)
