"""Sums in a fixed order."""

import numpy as np

from pellucid.reductions import ordered_sum


def test_chunks_are_added_in_order():
    """1 + 1e16 - 1e16 from left to right is 0 in double precision; any other order gives 1."""
    chunks = np.array([[1.0, 2.0], [1e16, 1e16], [-1e16, -1e16]])
    assert ordered_sum(chunks).tolist() == [0.0, 2.0]
    assert ordered_sum(chunks[[1, 2, 0]]).tolist() == [1.0, 2.0]


def test_one_chunk_is_itself():
    assert ordered_sum(np.array([[0.1, 0.2, 0.3]])).tolist() == [0.1, 0.2, 0.3]


def test_long_sums_do_not_depend_on_blocks():
    """numpy's own sum adds in pairs; this one must be the plain loop, whatever the length."""
    numbers = np.random.default_rng(0).normal(size=(1000, 2)) * 10.0 ** np.arange(1000).reshape(-1, 1) ** 0.5
    expected = np.zeros(2)
    for row in numbers:
        expected += row
    assert np.array_equal(ordered_sum(numbers), expected)
