"""Sums over the elements of a film of what their rows give: symmetric sparse matrices, forces and rates.

A matrix is a sum of squares, Σ factor row ⊗ row, so it never has a negative eigenvalue where no factor is negative. Every node
adds up its own rows of the matrix, element by element: one order, whatever the threads.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for
from pellucid.jit.vector import LANES, load, splat, spread, store

CHUNK = 256  # nodes or elements


class Rows(NamedTuple):
    """r rows of each element over its m nodes with d components, with a factor each."""

    rows: np.ndarray  # (e, r, m d)
    factor: np.ndarray  # (e, r)


def rows(values: np.ndarray, factor: np.ndarray) -> Rows:
    """Of rows (e, ..., m, d), with factors (e, ...) that broadcast to them."""
    e, (m, d) = len(values), values.shape[-2:]
    whole = np.array(np.broadcast_to(factor, values.shape[:-2]), dtype=float)  # kernels want writable arrays: one type for all
    return Rows(np.ascontiguousarray(values.reshape(e, -1, m * d)), whole.reshape(e, -1))


class Pattern(NamedTuple):
    """Where the numbers of a matrix stand; made once for all matrices of the same elements."""

    nodes: np.ndarray  # (e, m)
    d: int
    first: np.ndarray  # (n + 1,) blocks of each row of nodes, d × d numbers each
    column: np.ndarray  # nodes of the blocks, ascending in each row
    place: np.ndarray  # (e, m, m) of the block of two nodes of an element in its row
    use_first: np.ndarray  # (n + 1,)
    use: np.ndarray  # of node i from use_first[i] on: m e + a for each element e that has it as its node a, ascending


@kernel(inner=True)
def _place_chunk(chunk, pattern):
    nodes, first, column = pattern.nodes, pattern.first, pattern.column
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(nodes))):
        for a in range(nodes.shape[1]):
            i = nodes[e, a]
            for b in range(nodes.shape[1]):
                low, high = first[i], first[i + 1]
                while high - low > 1:
                    middle = (low + high) // 2
                    if column[middle] <= nodes[e, b]:
                        low = middle
                    else:
                        high = middle
                pattern.place[e, a, b] = low - first[i]


@kernel()
def _find_places(chunks, pattern):
    parallel_for(_place_chunk, chunks, pattern)


@kernel(inner=True)
def _node_rows(at, a, d, R, M, rows, factor, first, shares, part):
    """Fill part, 3 rows of M numbers, with what R rows give to the rows of the matrix of node a of an element."""
    for r in range(R):
        for c in range(d):
            shares[3 * r + c] = factor[first + r] * rows[at + r * M + d * a + c]
    for k in range(0, M, LANES):
        x, y, z = splat(0.0), splat(0.0), splat(0.0)
        for r in range(R):
            row = load(rows, at + r * M + k)
            x += spread(shares, 3 * r) * row
            y += spread(shares, 3 * r + 1) * row
            z += spread(shares, 3 * r + 2) * row
        store(part, k, x)
        store(part, M + k, y)
        store(part, 2 * M + k, z)


@kernel(inner=True)
def _matrix_chunk(chunk, pattern, rows, factor, R, M, values):
    m, d = pattern.nodes.shape[1], pattern.d
    shares, part = np.zeros(3 * R), np.zeros(3 * M)
    for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(pattern.first) - 1)):
        width = d * (pattern.first[i + 1] - pattern.first[i])
        start = d * d * pattern.first[i]
        values[start : start + d * width] = 0.0
        for u in range(pattern.use_first[i], pattern.use_first[i + 1]):
            e, a = pattern.use[u] // m, pattern.use[u] % m
            _node_rows(e * R * M, a, d, R, M, rows, factor, e * R, shares, part)
            for c in range(d):
                for b in range(m):
                    at = start + c * width + d * pattern.place[e, a, b]
                    for k in range(d):
                        values[at + k] += part[c * M + d * b + k]


@kernel()
def _add_squares(chunks, pattern, rows, factor, R, M, values):
    parallel_for(_matrix_chunk, chunks, pattern, rows, factor, R, M, values)


@kernel(inner=True)
def _gather_chunk(chunk, pattern, forms, result):
    m, d = pattern.nodes.shape[1], pattern.d
    for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(result))):
        result[i] = 0.0
        for u in range(pattern.use_first[i], pattern.use_first[i + 1]):
            e, a = pattern.use[u] // m, pattern.use[u] % m
            for form in forms:
                for r in range(form.rows.shape[1]):
                    for c in range(d):
                        result[i, c] += form.factor[e, r] * form.rows[e, r, d * a + c]


@kernel()
def _gather(chunks, pattern, forms, result):
    parallel_for(_gather_chunk, chunks, pattern, forms, result)


@kernel(inner=True)
def _rate_chunk(chunk, pattern, form, v, rates):
    nodes, d = pattern.nodes, pattern.d
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(nodes))):
        for r in range(form.rows.shape[1]):
            rate = 0.0
            for a in range(nodes.shape[1]):
                for c in range(d):
                    rate += form.rows[e, r, d * a + c] * v[nodes[e, a], c]
            rates[e, r] = rate


@kernel()
def _find_rates(chunks, pattern, form, v, rates):
    parallel_for(_rate_chunk, chunks, pattern, form, v, rates)


class Assembly:
    """The sums over elements with nodes (e, m), n in all, with d components each."""

    def __init__(self, nodes: np.ndarray, n: int, d: int) -> None:
        e, m = nodes.shape
        use = np.argsort(nodes.ravel(), kind="stable")
        use_first = np.concatenate([[0], np.cumsum(np.bincount(nodes.ravel(), minlength=n))])
        incidence = csr_array((np.ones(e * m, np.int32), (nodes.ravel(), np.repeat(np.arange(e), m))), shape=(n, e))
        blocks = csr_array(incidence @ incidence.T)
        blocks.sort_indices()
        first, column = blocks.indptr.astype(np.int64), blocks.indices.astype(np.int64)
        self._pattern = Pattern(nodes, d, first, column, np.empty((e, m, m), np.int32), use_first, use)
        _find_places(-(-e // CHUNK), self._pattern)
        self._rows, self._factor = np.empty((0, 0, 0)), np.empty((0, 0))
        self.n, self.d, self._chunks = n, d, -(-n // CHUNK)
        width = np.diff(first)
        self._indptr = np.concatenate([[0], np.cumsum(np.repeat(d * width, d))]).astype(np.int32)
        self._indices = self._columns(width)

    def _columns(self, width: np.ndarray) -> np.ndarray:
        """Of the numbers of the matrix, shape (numbers,)."""
        d, first, column = self.d, self._pattern.first, self._pattern.column
        row = np.repeat(np.arange(self.n), d)
        start = np.repeat(first[row], width[row])
        within = np.arange(len(start)) - np.repeat(np.cumsum(width[row]) - width[row], width[row])
        return (d * column[start + within][:, None] + np.arange(d)).ravel().astype(np.int32)

    def matrix(self, squares: Sequence[Rows]) -> csr_array:
        """Σ factor row ⊗ row of all of them, shape (n d, n d); node by node."""
        values = np.empty(len(self._indices))
        self._collect(squares)
        e, R, M = self._rows.shape
        _add_squares(self._chunks, self._pattern, self._rows.reshape(-1), self._factor.reshape(-1), R, M, values)
        return csr_array((values, self._indices, self._indptr), shape=(self.n * self.d, self.n * self.d))

    def _collect(self, squares: Sequence[Rows]) -> None:
        """All rows side by side, each filled up with zeros to whole vectors; in memory that is kept, as new memory is slow."""
        used = [square for square in squares if square.factor.any()]
        e, R, M = len(self._pattern.nodes), sum(square.factor.shape[1] for square in used), self._pattern.nodes.shape[1] * self.d
        if self._rows.shape[1] != R:
            self._rows, self._factor = np.zeros((e, R, -(-M // LANES) * LANES)), np.empty((e, R))
        at = 0
        for values, factor in used:
            here = slice(at, at + factor.shape[1])
            self._rows[:, here, :M], self._factor[:, here] = values, factor
            at = here.stop

    def gathered(self, forms: Sequence[Rows]) -> np.ndarray:
        """Σ factor row of all of them, shape (n, d)."""
        result = np.empty((self.n, self.d))
        _gather(self._chunks, self._pattern, tuple(forms), result)
        return result

    def rates(self, form: Rows, v: np.ndarray) -> np.ndarray:
        """row · v of nodal values v, shape (n, d): shape (e, r). Factors do not count."""
        result = np.empty(form.factor.shape)
        _find_rates(-(-len(self._pattern.nodes) // CHUNK), self._pattern, form, np.ascontiguousarray(v), result)
        return result
