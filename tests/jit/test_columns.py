from typing import NamedTuple

import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.columns import BLOCK, WIDTH, moved, no_sums, outer, plus, put, size, take, take_lanes
from pellucid.jit.memory import numbers
from pellucid.jit.vector import LANES, larger, load, nothing, row, store, total


class State(NamedTuple):
    stress: tuple[float, float]
    energy: float


@kernel()
def round_trip(a, out):
    """Points one by one into columns, and out of them by vectors, with the energy doubled."""
    c = numbers(WIDTH * size(((0.0, 0.0), 0.0)))
    for q in range(BLOCK):
        put(c, q, State((a[q, 0], a[q, 1]), a[q, 2]))
    like = State((0.0, 0.0), 0.0)
    for q in range(0, BLOCK, LANES):
        lanes = take_lanes(like, c, q)
        put(c, q, State(lanes.stress, 2.0 * lanes.energy))
    for q in range(BLOCK):
        state = take(like, c, q)
        out[q, 0] = state.stress[0]
        out[q, 1] = state.stress[1]
        out[q, 2] = state.energy


def test_what_goes_in_comes_out():
    a, out = np.random.default_rng(1).normal(size=(BLOCK, 3)), np.zeros((BLOCK, 3))
    round_trip(a, out)
    assert (out == a * (1.0, 1.0, 2.0)).all()


@kernel()
def last_vector(c, out):
    """A vector that begins at the last point of a block stays within its column."""
    put(c, BLOCK - 1, (row(1.0, 2.0, 3.0, 4.0),))
    store(out, 0, load(c, BLOCK - 1))


def test_a_vector_at_the_last_point_stays_in_its_column():
    c, out = np.zeros(2 * WIDTH), np.zeros(LANES)
    last_vector(c, out)
    assert (out == [1.0, 2.0, 3.0, 4.0]).all()
    assert not c[WIDTH:].any()


def test_columns_are_whole_vectors_of_eight():
    """Else no loop over a block becomes vectors of AVX-512."""
    assert WIDTH % 8 == 0


@kernel()
def combined(a, out):
    store(out, 0, larger(load(a, 0), load(a, LANES)))
    return total(nothing(load(a, 0))) + nothing(a[0])


def test_the_larger_of_each_lane():
    a, out = np.array([1.0, np.nan, -2.0, 5.0, 0.0, 3.0, -1.0, 7.0]), np.zeros(LANES)
    assert combined(a, out) == 0.0
    assert (out == [1.0, 3.0, -1.0, 7.0]).all(), "of the second where the first is no number"


def test_a_tuple_takes_a_column_for_each_of_its_numbers():
    @kernel()
    def count():
        return size(((0.0, (1.0, 2.0)), 3.0))

    assert count() == 4


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
