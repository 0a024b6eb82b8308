"""Rearranges shape-function data at quadrature points for kernels: packs of four points with a common list of nodes.

A pack has four points of one cell or, with one point per cell, the points of four cells that are adjacent in their order.
Lanes (entries of a SIMD vector) without a point, at the end, have zero weight.
"""

from math import frexp, ldexp
from typing import Any, NamedTuple

import numpy as np

from pellucid.approximants.nodal.lists import Lists
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES
from pellucid.tensors import cofactor, determinant

CHUNK = 256  # packs that one thread processes at a time
DIGITS = 24  # binary digits of a number in single precision


class Source(NamedTuple):
    """Shape-function data to be rearranged into packs (four quadrature points), with the node lists of cells and packs. The
    numbers at a point are sorted by component, and for each component by node of the cell.
    """

    n_points: int  # quadrature points per cell
    cells: Lists  # nodes of each cell
    packs: Lists  # nodes of each pack
    numbers: np.ndarray  # data, point by point


def pack_lists(cells: Lists, n_points: int) -> Lists:
    """Return the nodes of each pack (four quadrature points), from the nodes of each cell in ascending order. n_points:
    quadrature points per cell.
    """
    count, n_cells = np.diff(cells.first), len(cells.first) - 1
    if n_points % LANES == 0:
        times = n_points // LANES
        first = np.concatenate([[0], np.cumsum(np.repeat(count, times))])
        shift = np.repeat(np.repeat(cells.first[:-1], times) - first[:-1], np.diff(first))
        return Lists(first, cells.items[shift + np.arange(int(first[-1]))])
    size = LANES // n_points
    n, n_packs = int(cells.items.max()) + 1, -(-n_cells // size)
    keys = np.unique(np.repeat(np.arange(n_cells) // size, count) * n + cells.items)
    return Lists(np.searchsorted(keys, np.arange(n_packs + 1) * n), keys % n)


@kernel(inner=True)
def _take(pack, source, parts, out):
    """Fill `out` with the numbers of one pack (LANES quadrature points): for each of its nodes `parts` components at LANES
    points; zero for missing points. source: data of `Source`.
    """
    nq, cells, packs = source.n_points, source.cells, source.packs
    start, end = packs.first[pack], packs.first[pack + 1]
    out[: parts * LANES * (end - start)] = 0.0
    for lane in range(LANES):
        cell, q = (LANES * pack + lane) // nq, (LANES * pack + lane) % nq
        if cell >= len(cells.first) - 1:
            break
        n, entry = cells.first[cell + 1] - cells.first[cell], start
        at = parts * (nq * cells.first[cell] + q * n)
        for k in range(n):
            while packs.items[entry] < cells.items[cells.first[cell] + k]:
                entry += 1
            for part in range(parts):
                out[(parts * (entry - start) + part) * LANES + lane] = source.numbers[at + part * n + k]


@parallel_loop()
def _fill(chunk, source, parts, out):
    first = source.packs.first
    for pack in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(first) - 1)):
        _take(pack, source, parts, out[parts * LANES * first[pack] : parts * LANES * first[pack + 1]])


@kernel(inner=True)
def _round_together(n, step, numbers):
    """Round n numbers, a step apart in an array, whose exact sum is zero, in place, to multiples of the single-precision unit
    of the largest one.

    The partial sums are rounded, so that the rounded numbers, their differences, sum to exactly zero.
    """
    largest = 0.0
    for k in range(n):
        largest = max(largest, abs(numbers[k * step]))
    if largest == 0.0:
        return
    unit = ldexp(1.0, frexp(largest)[1] - DIGITS)
    total = before = 0.0
    for k in range(n):
        total += numbers[k * step] / unit
        here = np.rint(total) if k < n - 1 else 0.0
        numbers[k * step] = (here - before) * unit
        before = here


@kernel(inner=True, allocates=True)
def _turn(n, lane, nodes, position, g, K):
    """Compute K - I with K = (Σ x_a ⊗ g_a)⁻¹ at a point, so that the gradients Kᵀ g_a reproduce linear functions.

    n: number of nodes a; lane: position of the point in its pack; nodes: the nodes; position: x_a [m], shape (all nodes, 3);
    g: rounded gradients of the pack [1/m]; K: receives the result.
    """
    D = np.zeros((3, 3))
    for k in range(n):
        for i in range(3):
            x = position[nodes[k], i] - position[nodes[0], i]
            for j in range(3):
                D[i, j] += x * g[(3 * k + j) * LANES + lane]
    E = (D[0, 0], D[0, 1], D[0, 2], D[1, 0], D[1, 1], D[1, 2], D[2, 0], D[2, 1], D[2, 2])
    over, C = 1.0 / determinant(E), cofactor(E)
    for i in range(3):
        for j in range(3):
            K[(3 * i + j) * LANES + lane] = over * C[3 * j + i] - (i == j)


@parallel_loop(allocates=True)
def _fill_gradients(chunk, source, position, longest, rounded, gradients, turns):
    first, nodes, nq = source.packs.first, source.packs.items, source.n_points
    g = np.empty(3 * LANES * longest)
    for pack in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(first) - 1)):
        n = first[pack + 1] - first[pack]
        _take(pack, source, 3, g)
        for lane in range(min(LANES, nq * (len(source.cells.first) - 1) - LANES * pack)):
            if rounded:
                for axis in range(3):
                    _round_together(n, 3 * LANES, g[axis * LANES + lane :])
            _turn(n, lane, nodes[first[pack] : first[pack + 1]], position, g, turns[9 * LANES * pack : 9 * LANES * (pack + 1)])
        for k in range(3 * LANES * n):
            gradients[3 * LANES * first[pack] + k] = g[k]


def pack_numbers(cells: Lists, packs: Lists, n_points: int, numbers: np.ndarray) -> np.ndarray:
    """Rearrange data with one number per node and quadrature point into packs (four points): LANES numbers per entry of the
    packs' node lists.

    cells, packs: nodes of each cell and pack; n_points: quadrature points per cell; numbers: data, point by point.
    """
    out, chunks = np.empty(LANES * len(packs.items)), -(-(len(packs.first) - 1) // CHUNK)
    _fill(chunks, Bundle(Source(n_points, cells, packs, numbers)), 1, out)
    return out


def pack_gradients(
    cells: Lists, packs: Lists, n_points: int, rows: np.ndarray, position: np.ndarray, storage: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Rearrange gradients of shape functions into packs (four points), as rounded gradients g_a and a correction K with ∇p_a =
    Kᵀ g_a.

    Returns g_a, 3 × LANES numbers of type `storage` per entry of the node lists, and K - I, 9 × LANES numbers per pack. cells,
    packs: nodes of each cell and pack; n_points: quadrature points per cell; rows: gradients [1/m], point by point; position:
    nodal positions [m], shape (n, 3). In single precision the g_a of each point sum to exactly zero.
    """
    n_packs = len(packs.first) - 1
    gradients, turns = np.empty(3 * LANES * len(packs.items), storage), np.zeros(9 * LANES * n_packs, storage)
    longest, rounded = int(np.diff(packs.first).max()), np.dtype(storage) == np.float32
    source = Bundle(Source(n_points, cells, packs, rows))
    _fill_gradients(-(-n_packs // CHUNK), source, position, longest, rounded, gradients, turns)
    return gradients, turns
