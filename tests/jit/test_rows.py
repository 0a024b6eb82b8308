from typing import NamedTuple

import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.columns import WIDTH, put, take_lanes
from pellucid.jit.memory import numbers
from pellucid.jit.rows import (
    cross,
    expect_rows,
    keep_row,
    keep_rows,
    symmetric_at_point,
    take_row,
    take_rows,
    tensor_at_point,
    vector_at_point,
    with_last,
)
from pellucid.jit.vector import LANES, store
from pellucid.tensors import IDENTITY, ZERO_VECTOR

COUNT = LANES + 3  # rows of one vector of points and some beside it


class State(NamedTuple):
    stress: tuple[float, float, float, float, float, float]
    energy: float


LIKE = ZERO_VECTOR, 0.0, State((0.0, 0.0, 0.0, 0.0, 0.0, 0.0), 0.0), (IDENTITY, 0.0), IDENTITY, (0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
"""Parts of 3, 1, 6, 1, 10, 9, 2 and 4 numbers; each is one array."""
LENGTHS = 3, 1, 6, 1, 10, 9, 2, 4


def arrays_of(rng):
    x, m, stress, energy, *others = (rng.normal(size=(COUNT, k) if k > 1 else COUNT) for k in LENGTHS)
    return x, m, State(stress, energy), *others


def columns_of(arrays):
    x, m, state, *others = arrays
    return np.column_stack([x, m, state.stress, state.energy, *others])


@kernel()
def by_vectors(source, target, p, columns):
    values = take_rows(LIKE, source, np.uintp(p))
    put(columns, 0, values)
    keep_rows(target, np.uintp(p), take_lanes(LIKE, columns, 0))


@kernel()
def one_by_one(source, target, p, columns):
    values = take_row(LIKE, source, np.uintp(p))
    put(columns, 0, values)
    keep_row(target, np.uintp(p), values)


@pytest.mark.parametrize(("copy", "count"), [(by_vectors, LANES), (one_by_one, 1)])
@pytest.mark.parametrize("p", [0, 3])
def test_rows_are_taken_into_columns_and_kept_again(copy, count, p):
    source, target = arrays_of(np.random.default_rng(1)), arrays_of(np.random.default_rng(2))
    given, before = columns_of(source), columns_of(target)
    columns = np.zeros(given.shape[1] * WIDTH)
    copy(source, target, p, columns)
    assert np.array_equal(columns.reshape(-1, WIDTH)[:, :count], given[p : p + count].T)
    before[p : p + count] = given[p : p + count]
    assert np.array_equal(columns_of(target), before), "the other points are left alone"


@kernel()
def of_one_array(array, out):
    out[0] = take_row(0.0, array, np.uintp(2))
    c = numbers(WIDTH)
    put(c, 0, take_rows(0.0, array, np.uintp(1)))
    out[1] = c[LANES - 1]


def test_a_number_a_point_is_an_array_of_its_own():
    array, out = np.arange(float(COUNT)), np.zeros(2)
    of_one_array(array, out)
    assert out.tolist() == [2.0, LANES]


def test_arrays_in_another_order_are_refused():
    """They would be read at the wrong places."""
    source = np.asfortranarray(np.zeros((COUNT, 3))), *arrays_of(np.random.default_rng(1))[1:]
    with pytest.raises(Exception, match="arrays of doubles in C order"):
        one_by_one(source, source, 0, np.zeros(sum(LENGTHS) * WIDTH))


@kernel()
def look_ahead(arrays, p):
    expect_rows(LIKE, arrays, np.uintp(p))


@pytest.mark.parametrize("p", [0, COUNT - 1, 1000 * COUNT])
def test_to_expect_rows_changes_nothing_and_may_lead_beyond_the_arrays(p):
    arrays = arrays_of(np.random.default_rng(1))
    before = columns_of(arrays)
    look_ahead(arrays, p)
    assert np.array_equal(columns_of(arrays), before)


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
