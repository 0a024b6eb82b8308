"""Rows of points as vectors, in order and in the last place of an array."""

import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.point_rows import symmetric_at_point, tensor_at_point, vector_at_point
from pellucid.jit.vector import LANES, store


@kernel()
def rows_of(p, vectors, symmetric, tensors, out):
    store(out, 0, vector_at_point(vectors, np.uintp(p)))
    for d in range(3):
        store(out, LANES * (1 + d), symmetric_at_point(symmetric, np.uintp(p))[d])
        store(out, LANES * (4 + d), tensor_at_point(tensors, np.uintp(p))[d])


@pytest.mark.parametrize("p", [0, 2, 4])
def test_rows_are_those_of_the_point(p):
    vectors, symmetric, tensors = (np.random.default_rng(4).normal(size=(5, length)) for length in (3, 6, 10))
    out = np.full(7 * LANES, np.nan)
    rows_of(p, vectors, symmetric, tensors, out)
    found = out.reshape(7, LANES)
    assert (found[0] == [*vectors[p], 0.0]).all()
    xx, yy, zz, yz, xz, xy = symmetric[p]
    assert (found[1:4, :3] == [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).all()
    assert (found[4:, :3] == tensors[p, :9].reshape(3, 3).T).all()
