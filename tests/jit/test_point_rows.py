"""Rows of points as vectors, in order and in the last place of an array."""

import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.point_rows import cross, symmetric_at_point, tensor_at_point, vector_at_point, with_last
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


@kernel()
def products_of(vectors, out):
    store(out, 0, cross(vector_at_point(vectors, np.uintp(0)), vector_at_point(vectors, np.uintp(1))))
    store(out, LANES, with_last(vector_at_point(vectors, np.uintp(1)), 7.0))


def test_vector_products_and_last_lanes():
    vectors, out = np.random.default_rng(5).normal(size=(2, 3)), np.full(2 * LANES, np.nan)
    products_of(vectors, out)
    assert out[:LANES] == pytest.approx([*np.cross(*vectors), 0.0], rel=1e-14, abs=1e-15)
    assert (out[LANES:] == [*vectors[1], 7.0]).all()
