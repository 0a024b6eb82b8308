"""Loops of several bodies as one parallel region."""

import numba
import numpy as np
import pytest

from pellucid.jit import kernel
from pellucid.jit.loops import joint_by_colour, joint_for, joint_region, parallel_for
from pellucid.jit.region import MOST

COUNTS = [0, 1, 2, 3, 7, 1000]
compiled = pytest.mark.skipif(numba.config.DISABLE_JIT, reason="in plain Python loops do not wait")


@kernel(inner=True)
def _scale(s, values, factor):
    values[s] *= factor


@kernel(inner=True)
def _shift(s, values, by):
    values[s] += by


@kernel(inner=True)
def _add_to_both(s, seen, share):
    """Reaches the next chunk too, which must wait, for the first one takes long."""
    for _ in range(300 if s else 100_000):
        seen[s] += share
        seen[s + 1] = 0.5 * seen[s + 1] + seen[s]


@kernel()
def scale(count, values, factor):
    joint_for(_scale, count, values, factor)


@kernel()
def shift(count, values, by):
    joint_for(_shift, count, values, by)


@kernel()
def shift_now(count, values, by):
    parallel_for(_shift, count, values, by)


@kernel()
def add_to_both(count, seen, share):
    joint_by_colour(_add_to_both, count, 1, seen, share)


@compiled
def test_joint_loops_wait_and_others_do_not():
    values, others = np.ones(5), np.ones(5)
    with joint_region:
        scale(5, values, 2.0)
        shift_now(5, others, 1.0)
        assert np.all(values == 1.0)
        assert np.all(others == 2.0)
    assert np.all(values == 2.0)
    scale(5, values, 2.0)
    assert np.all(values == 4.0), "outside of a region they are done at once"


@pytest.mark.parametrize("count", COUNTS)
def test_chunks_go_loop_after_loop(threads, count):
    """Of different lengths; a loop takes what an earlier one left."""
    values, fewer = np.arange(1000.0), np.arange(1000.0)
    with joint_region:
        scale(count, values, 3.0)
        scale(count // 2, fewer, 3.0)
        shift(count, values, 1.0)
        shift(count // 3, fewer, 1.0)
    n = np.arange(1000)
    assert np.array_equal(values, np.where(n < count, 3.0 * n + 1.0, n))
    assert np.array_equal(fewer, np.where(n < count // 2, 3.0 * n, n) + (n < count // 3))


@compiled
@pytest.mark.parametrize("count", COUNTS)
def test_loops_by_colour_add_to_the_same_nodes_in_one_order(threads, count):
    seen, expected = np.zeros(1002), np.zeros(1002)
    with joint_region:
        add_to_both(count, seen, 1.0)
        add_to_both(count, seen, 0.25)
    for colour in range(2):
        for s in range(colour, count, 2):
            _add_to_both.py_func(s, expected, 1.0)
            _add_to_both.py_func(s, expected, 0.25)
    assert np.array_equal(seen, expected)


@compiled
def test_loops_for_which_there_is_no_room_are_done_at_once():
    values = np.zeros(MOST + 10)
    with joint_region:
        for done in range(MOST + 10):
            shift(MOST + 10, values, 1.0)
            assert values[0] == max(0, done + 1 - MOST)
    assert np.all(values == MOST + 10)
    with joint_region:
        shift(3, values, 1.0)
        assert values[0] == MOST + 10, "the next region has all the room again"


def _shift_and_fail(values):
    with joint_region:
        shift(3, values, 1.0)
        shift(3, values, 1.0 / 0)


def test_bodies_of_any_number_keep_their_order_where_room_is_made():
    """A loop that takes what an earlier one left is not done before it."""
    values = np.ones((MOST, 3))
    with joint_region:
        for body in values:
            joint_region.make_room()
            scale(3, body, 2.0)
            shift(3, body, 1.0)
            scale(3, body, 2.0)
    assert np.all(values == 6.0)


@compiled
def test_an_error_in_the_block_drops_the_loops():
    values = np.zeros(3)
    with pytest.raises(ZeroDivisionError):
        _shift_and_fail(values)
    assert np.all(values == 0.0)
    with joint_region:
        shift(3, values, 1.0)
    assert np.all(values == 1.0)
