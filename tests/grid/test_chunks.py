"""Nodes in chunks, each within a row of slabs."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as some

from pellucid.grid.chunks import ALL, by_row, chunked

ROWS = np.array([0, 7, 7, 40, 60])


@given(some.sets(some.integers(0, 59)), some.integers(1, 9))
def test_chunks_are_the_listed_nodes_in_order_within_rows(nodes, most):
    node = np.array(sorted(nodes), np.int64)
    found = by_row(ROWS, node, most)
    edges, of_row = found.chunks.edges, found.of_row
    assert edges[0] == 0
    assert edges[-1] == len(node)
    assert np.all((np.diff(edges) > 0) & (np.diff(edges) <= most))
    assert len(of_row) == len(ROWS)
    assert of_row[-1] == found.chunks.n
    for row, (first, end) in enumerate(itertools.pairwise(of_row)):
        within = node[edges[first] : edges[end]]
        assert np.array_equal(within, node[(node >= ROWS[row]) & (node < ROWS[row + 1])])


def test_all_nodes_need_no_list():
    found = by_row(ROWS, most=10)
    assert found.chunks.node is ALL
    assert found.chunks.edges.tolist() == [0, 7, 15, 23, 31, 40, 50, 60]
    assert found.of_row.tolist() == [0, 1, 1, 5, 7]


@pytest.mark.parametrize("n", [0, 1, 512, 513])
def test_a_list_in_chunks_has_all_of_it(n):
    edges = chunked(np.arange(n)).edges
    assert edges[0] == 0
    assert edges[-1] == n
    assert len(edges) - 1 == -(-n // 512)
