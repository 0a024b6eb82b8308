"""Blocks of points: vectors of points find what single points find, for runs of any length.

For every grid function the tests of the transfers compare scatter and gather with exact fields.
"""

import numpy as np
import pytest
from small_cases import box, place, simulation

from pellucid.grid.passes.blocks import (
    about_lanes,
    add_columns,
    fetch,
    find_functions,
    functions_like,
    keep,
    largest_of_column,
    run_end,
)
from pellucid.grid.points import ByIndex, InOrder
from pellucid.grid.stencil import gather, stencil
from pellucid.jit import kernel
from pellucid.jit.columns import BLOCK, WIDTH, put, size
from pellucid.jit.memory import indices, numbers
from pellucid.jit.vector import LANES, load, total
from pellucid.tensors import ZERO_VECTOR


@kernel()
def by_vectors(mapped, field, n, out):
    functions, lattice = mapped.functions, mapped.lattice
    found, first_node, place = (
        numbers(WIDTH * size(functions_like(functions))),
        indices(BLOCK),
        numbers(WIDTH * size(ZERO_VECTOR)),
    )
    fetch(mapped.index, ZERO_VECTOR, mapped.points.position, 0, n, place, 0)
    find_functions(functions, lattice, n, place, 0, found, first_node)
    a = 0
    while a < n:
        end = run_end(first_node, a, n)
        while a < end:
            about = about_lanes(functions, found, first_node, a)
            put(out, a, gather(about, lattice, field))
            a += LANES
        a = end


@kernel()
def one_by_one(mapped, field, n, out):
    for q in range(n):
        about = stencil(mapped.functions, mapped.lattice, mapped.points.position, q)
        put(out, q, gather(about, mapped.lattice, field))


@pytest.mark.parametrize(("functions", "counts"), [("trilinear", (3, 2, 2)), ("trilinear", (3, 4, 1)), ("gimp", (3, 2, 2))])
def test_vectors_of_points_find_what_points_find(functions, counts):
    sim = simulation(box((0, 0, 0), counts), counts=counts, functions=functions)
    body, rng = sim.bodies[0], np.random.default_rng(2)
    place(body, rng.random((body.n_points, 3)) * counts)  # at random: runs of one point to several, walls included
    field = rng.normal(size=(sim.grid.n_nodes, 3))
    for n in (1, 3, min(BLOCK, body.n_points)):
        by_lanes, alone = np.zeros(3 * WIDTH), np.zeros(3 * WIDTH)
        by_vectors(body.mapped, field, n, by_lanes)
        one_by_one(body.mapped, field, n, alone)
        # sums of up to 27 terms, in which products may be rounded once or twice
        assert by_lanes.reshape(3, WIDTH)[:, :n] == pytest.approx(alone.reshape(3, WIDTH)[:, :n], abs=1e-13)


@kernel()
def sums_of(c, n, sums):
    add_columns(c, 0, n, sums, 0, 2)
    largest_of_column(c, 2, n, sums, 2)
    return total(load(sums, 0)), total(load(sums, LANES))


@pytest.mark.parametrize("n", [1, 4, 7, BLOCK])
def test_sums_and_the_largest_are_of_the_points_alone(n):
    rng = np.random.default_rng(3)
    columns = rng.random((3, WIDTH)) + 1.0
    columns[:, n:] = 100.0  # what vectors left beyond the last point
    c, sums = columns.reshape(-1).copy(), np.zeros(3 * LANES)
    assert sums_of(c, n, sums) == pytest.approx(columns[:2, :n].sum(axis=1), rel=1e-14)
    assert sums[2 * LANES :].max() == columns[2, :n].max()


@kernel()
def back_and_forth(index, source, target, start, n, c):
    fetch(index, (0.0, ZERO_VECTOR), source, start, n, c, WIDTH)
    keep(index, (0.0, ZERO_VECTOR), target, start, n, c, WIDTH)


@pytest.mark.parametrize("n", [1, 4, 7, BLOCK])
@pytest.mark.parametrize("shuffled", [False, True])
def test_rows_of_a_block_go_into_columns_and_back(n, shuffled):
    """Of points in order and of others; what lies beyond the block is left alone."""
    rng = np.random.default_rng(4)
    m, x = rng.random(50), rng.random((50, 3))
    order = rng.permutation(50) if shuffled else np.arange(50)
    index, start, c = ByIndex(order) if shuffled else InOrder(), 5, np.zeros(5 * WIDTH)
    kept = np.zeros(50), np.zeros((50, 3))
    back_and_forth(index, (m, x), kept, start, n, c)
    taken = order[start : start + n]
    assert np.array_equal(c.reshape(5, WIDTH)[1:, :n], np.column_stack([m, x])[taken].T)
    m[np.setdiff1d(np.arange(50), taken)] = 0.0
    assert np.array_equal(kept[0], m)
    assert np.array_equal(kept[1], np.where(m[:, None] > 0.0, x, 0.0))
