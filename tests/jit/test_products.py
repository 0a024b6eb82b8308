"""Sums of weighted vectors in tuples, against plain arrays."""

import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.products import moved, no_sums, outer, plus
from pellucid.jit.vector import LANES, load, store


@kernel()
def summed(a, rows, out):
    weights = outer((a[0], a[1], a[2]), (a[3], a[4]))
    sums = no_sums(weights)
    one, step = load(rows, 0), load(rows, LANES)
    for _ in range(2):
        sums = plus(sums, weights, one)
    sums = plus(sums, weights, moved((one, step), (0.0, 0.0, 0.0), step))
    for k in range(6):
        store(out, LANES * k, sums[k])


def test_sums_are_those_of_arrays():
    rng = np.random.default_rng(3)
    a, rows, out = rng.normal(size=5), rng.normal(size=2 * LANES), np.zeros(6 * LANES)
    summed(a, rows, out)
    weights, (one, step) = np.outer(a[:3], a[3:]).ravel(), rows.reshape(2, LANES)
    others = [one, step, one + step, step + step, one + 2.0 * step, step + 2.0 * step]
    expected = [w * (2.0 * one + other) for w, other in zip(weights, others, strict=True)]
    assert out == pytest.approx(np.concatenate(expected), rel=1e-14, abs=1e-15)
