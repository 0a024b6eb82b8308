"""Sums in a fixed order."""

from math import fsum

import numpy as np
import pytest

from pellucid.reductions import exact_parts, ordered_sum


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


@pytest.mark.parametrize("pieces", [1, 2, 7])
def test_exact_parts_have_the_sum_of_all_values(pieces):
    generator = np.random.default_rng(pieces)
    values = generator.normal(size=500) * 10.0 ** generator.integers(-30, 30, 500)
    parts = [part for piece in np.array_split(values, pieces) for part in exact_parts(piece)]
    assert fsum(parts) == fsum(values)
    assert len(parts) < 10 * pieces


def test_nothing_has_no_parts():
    assert exact_parts(np.zeros(3)) == exact_parts(np.zeros(0)) == []
