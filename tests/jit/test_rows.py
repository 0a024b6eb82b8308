"""Rows of arrays: what is taken of points, one by one or by vectors, is what the arrays hold, and goes back where it was."""

from typing import NamedTuple

import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.columns import WIDTH, put, take_lanes
from pellucid.jit.local import numbers
from pellucid.jit.rows import expect_rows, keep_row, keep_rows, take_row, take_rows
from pellucid.jit.vector import LANES
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
