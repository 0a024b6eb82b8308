"""Vectors of four doubles in kernels, against plain arrays."""

import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.vector import LANES, load, splat, spread, store, total, totals, where_positive


@kernel()
def combined(a, b, out):
    x, y = load(a, 0), load(b, LANES)
    z = 2.0 * x - y * x + splat(0.5)
    z += y / 3.0
    store(out, 0, z)
    return total(z)


@pytest.mark.parametrize("precision", [np.float64, np.float32])
def test_arithmetic_is_that_of_arrays(precision):
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=LANES).astype(precision), rng.normal(size=2 * LANES)
    out = np.zeros(LANES)
    found = combined(a, b, out)
    x, y = a.astype(float), b[LANES:]
    expected = 2.0 * x - y * x + 0.5 + y / 3.0
    assert out == pytest.approx(expected, rel=1e-15, abs=1e-15)  # a product and a sum may round once
    assert found == pytest.approx(expected.sum(), abs=1e-14)


def test_the_lanes_are_added_in_a_fixed_order():
    lanes = np.array([1e16, -1e16, 1.0, 1.0])
    out = np.zeros(LANES)
    # neighbours first: (1e16 - 1e16) + (1 + 1), where in another order a one would be lost
    assert combined(lanes * 0.0, np.concatenate([lanes * 0.0, 3.0 * (lanes - 0.5)]), out) == pytest.approx(2.0, abs=1e-9)


@kernel()
def summed(a, out):
    store(out, 0, totals(load(a, 0), load(a, LANES), spread(a, 2)))


def test_three_vectors_are_added_up_together():
    a, out = np.random.default_rng(2).normal(size=2 * LANES), np.zeros(LANES)
    summed(a, out)
    pairs = a.reshape(2, 2, 2).sum(axis=2).sum(axis=1)  # the order in which one is
    assert (out == [*pairs, 4.0 * a[2], 4.0 * a[2]]).all()


@kernel()
def chosen(a, out):
    store(out, 0, where_positive(load(a, 0), load(a, LANES), splat(7.0)))


def test_lanes_are_taken_where_another_is_positive():
    a, out = np.array([1.0, 0.0, -1.0, np.nan, 2.0, 3.0, 4.0, 5.0]), np.zeros(LANES)
    chosen(a, out)
    assert out.tolist() == [2.0, 7.0, 7.0, 7.0]
