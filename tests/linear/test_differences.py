"""Derivatives of forces by differences of whole groups of nodes."""

import numpy as np
import pytest
from scipy.sparse import csr_array

from pellucid.linear.differences import GroupedDifferences


def springs_between(n, reach):
    """Links of a ring of n nodes to their neighbours up to `reach`, as pairs."""
    return np.array([(a, (a + k) % n) for a in range(n) for k in range(1, reach + 1)])


def links_of(pairs, n):
    one, other = pairs.T
    every = np.arange(n)
    rows, columns = np.concatenate([one, other, every]), np.concatenate([other, one, every])
    links = csr_array((np.ones(len(rows)), (rows, columns)), (n, n))
    links.sum_duplicates()
    links.sort_indices()
    return links


def forces_of(pairs, rest):
    """Forces of springs whose lengths at rest are those of the positions `rest`."""

    def forces(x):
        along = x[pairs[:, 1]] - x[pairs[:, 0]]
        length = np.linalg.norm(along, axis=1)
        pull = (length - np.linalg.norm(rest[pairs[:, 1]] - rest[pairs[:, 0]], axis=1)) / length
        found = np.zeros_like(x)
        np.add.at(found, pairs[:, 0], pull[:, None] * along)
        np.add.at(found, pairs[:, 1], -pull[:, None] * along)
        return found

    return forces


def test_derivatives_are_those_of_single_nodes():
    rng = np.random.default_rng(1)
    n, step = 40, 1e-5
    pairs, rest = springs_between(n, 3), rng.normal(size=(n, 3))
    x, forces, links = rest + 0.1 * rng.normal(size=(n, 3)), forces_of(pairs, rest), links_of(pairs, n)
    found = GroupedDifferences(links, step).find(forces, x)
    row, column = np.repeat(np.arange(n), np.diff(links.indptr)), links.indices
    stiffness = np.zeros((n, 3, n, 3))
    stiffness[row, :, column] = found
    for node in (0, 7, n - 1):
        for axis in range(3):
            moved = np.zeros((n, 3))
            moved[node, axis] = step
            exact = (forces(x - moved) - forces(x + moved)) / (2.0 * step)
            assert stiffness[:, :, node, axis] == pytest.approx(exact, abs=1e-8)


def test_the_number_of_evaluations_does_not_grow_with_the_number_of_nodes():
    numbers = []
    for n in (70, 700):
        asked = []
        differences = GroupedDifferences(links_of(springs_between(n, 3), n), 1e-5)
        differences.find(lambda x, asked=asked: asked.append(x) or np.zeros_like(x), np.zeros((n, 3)))
        numbers.append(len(asked))
    assert numbers[0] == numbers[1] == 6 * 7, "seven nodes have no common neighbour"


def test_the_symmetric_part_is_taken():
    links = links_of(np.array([(0, 1)]), 2)
    turn = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    found = GroupedDifferences(links, 1e-3).find(lambda x: -x[::-1] @ turn.T, np.zeros((2, 3)))
    between = found[1], found[2]  # (0, 1) and (1, 0)
    assert between[0] == pytest.approx(0.5 * (turn + turn.T))
    assert between[0] == pytest.approx(between[1].T)
