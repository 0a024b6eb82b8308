"""Symmetric sparse matrices of films, assembled as Σ factor row ⊗ row from linear forms of the nodal velocities of each
element (`ElementRows`; row: the coefficients of a form). Such a matrix has no negative eigenvalue if no factor is negative.

Every node sums its own rows of the matrix element by element in a fixed order, so that results do not depend on the number of
threads.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.bodies.fluid_film.forms.nodal_sums import CHUNK, ElementRows, NodalSums, SharedRows
from pellucid.jit import kernel
from pellucid.jit.local import zeros
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES, load, splat, spread, store

BLOCK = 3 * LANES  # coefficients of a row that are summed together: those of four nodes


class Pattern(NamedTuple):
    """Sparsity pattern of a matrix of d × d blocks, one for each pair of nodes that share an element; built once for all
    matrices of the same elements.
    """

    first: np.ndarray  # (n + 1,) index of the first block of each node's rows
    column: np.ndarray  # (blocks,) node of each block's columns, ascending in each row
    place: np.ndarray  # (e, m, m) for two nodes of an element, index of their block among the blocks of its row


@parallel_loop()
def _find_places(chunk, uses, pattern):
    nodes, first, column = uses.nodes, pattern.first, pattern.column
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


@kernel(inner=True)
def _node_rows(at, a, R, M, rows, factor, first, shares, part):
    """Add up the contributions of R linear forms of an element to the three matrix rows of its node a; write the sums to
    `part`, 3 rows of M numbers.

    rows, factor: coefficients and factors of the forms of all elements, flat arrays; at, first: index of the first
    coefficient and of the first factor of this element; shares: work array of 3 R numbers.
    """
    for r in range(R):
        for c in range(3):
            shares[3 * r + c] = factor[first + r] * rows[at + r * M + 3 * a + c]
    for k in range(0, M, BLOCK):  # nine sums at a time: the processor has them under way together
        x0, y0, z0 = splat(0.0), splat(0.0), splat(0.0)
        x1, y1, z1 = splat(0.0), splat(0.0), splat(0.0)
        x2, y2, z2 = splat(0.0), splat(0.0), splat(0.0)
        for r in range(R):
            x, y, z = spread(shares, 3 * r), spread(shares, 3 * r + 1), spread(shares, 3 * r + 2)
            start = at + r * M + k
            row0, row1, row2 = load(rows, start), load(rows, start + LANES), load(rows, start + 2 * LANES)
            x0 += x * row0
            y0 += y * row0
            z0 += z * row0
            x1 += x * row1
            y1 += y * row1
            z1 += z * row1
            x2 += x * row2
            y2 += y * row2
            z2 += z * row2
        store(part, k, x0)
        store(part, k + LANES, x1)
        store(part, k + 2 * LANES, x2)
        store(part, M + k, y0)
        store(part, M + k + LANES, y1)
        store(part, M + k + 2 * LANES, y2)
        store(part, 2 * M + k, z0)
        store(part, 2 * M + k + LANES, z1)
        store(part, 2 * M + k + 2 * LANES, z2)


@parallel_loop()
def _add_squares(chunk, uses, pattern, rows, factor, R, M, shared, values):
    m = uses.nodes.shape[1]
    shares, part = zeros(3 * R), zeros(3 * M)
    for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(pattern.first) - 1)):
        width = 3 * (pattern.first[i + 1] - pattern.first[i])
        start = 9 * pattern.first[i]
        values[start : start + 3 * width] = 0.0
        for u in range(uses.first[i], uses.first[i + 1]):
            e, a = uses.use[u] // m, uses.use[u] % m
            _node_rows(e * R * M, a, R, M, rows, factor, e * R, shares, part)
            for b in range(m):
                square = 0.0
                for r in range(shared.factor.shape[1]):
                    square += shared.factor[e, r] * shared.rows[e, r, a] * shared.rows[e, r, b]
                at = start + 3 * pattern.place[e, a, b]
                for c in range(3):
                    of = c * M + 3 * b
                    values[at] += part[of]
                    values[at + 1] += part[of + 1]
                    values[at + 2] += part[of + 2]
                    values[at + c] += square
                    at += width


def _side_by_side(shared: Sequence[SharedRows], e: int, m: int) -> SharedRows:
    """Concatenate linear forms (`SharedRows`) of the same e elements with m nodes each."""
    rows, factor = np.empty((e, 0, m)), np.empty((e, 0))
    return SharedRows(
        np.concatenate([rows, *(one.rows for one in shared)], axis=1),
        np.concatenate([factor, *(one.factor for one in shared)], axis=1),
    )


def _merged(squares: Sequence[ElementRows]) -> list[ElementRows]:
    """Merge linear forms of the same elements: sum the factors of identical forms, and omit forms whose factors are all
    zero.
    """
    found: dict[tuple[int, tuple[int, ...]], ElementRows] = {}
    for square in squares:
        key = (square.rows.__array_interface__["data"][0], square.rows.shape)
        if key in found:
            square = ElementRows(square.rows, found[key].factor + square.factor)
        if square.factor.any():
            found[key] = square
    return list(found.values())


class Assembly(NodalSums):
    """Assembles nodal vectors and sparse matrices from the linear forms (`ElementRows`) of elements with nodes (e, m), for n
    nodes with d components each.
    """

    def __init__(self, nodes: np.ndarray, n: int, d: int) -> None:
        super().__init__(nodes, n, d)
        e, m = nodes.shape
        incidence = csr_array((np.ones(e * m, np.int32), (nodes.ravel(), np.repeat(np.arange(e), m))), shape=(n, e))
        blocks = csr_array(incidence @ incidence.T)
        blocks.sort_indices()
        first, column = blocks.indptr.astype(np.int64), blocks.indices.astype(np.int64)
        self._pattern = Pattern(first, column, np.empty((e, m, m), np.int32))
        _find_places(-(-e // CHUNK), self._uses, self._pattern)
        self._rows, self._factor = np.empty((0, 0, 0)), np.empty((0, 0))
        width = np.diff(first)
        self._indptr = np.concatenate([[0], np.cumsum(np.repeat(d * width, d))]).astype(np.int32)
        self._indices = self._columns(width)

    def _columns(self, width: np.ndarray) -> np.ndarray:
        """Return the column index of each stored entry of the matrix, shape (entries,). width: number of blocks in the rows of
        each node, shape (n,).
        """
        d, first, column = self.d, self._pattern.first, self._pattern.column
        row = np.repeat(np.arange(self.n), d)
        start = np.repeat(first[row], width[row])
        within = np.arange(len(start)) - np.repeat(np.cumsum(width[row]) - width[row], width[row])
        return (d * column[start + within][:, None] + np.arange(d)).ravel().astype(np.int32)

    def matrix(self, squares: Sequence[ElementRows | SharedRows]) -> csr_array:
        """Assemble the matrix Σ factor row ⊗ row over all given linear forms, shape (n d, n d), ordered by node; `row` are the
        coefficients of a form.
        """
        values = np.empty(len(self._indices))
        self._collect([square for square in squares if isinstance(square, ElementRows)])
        shared = _side_by_side([square for square in squares if isinstance(square, SharedRows)], *self._uses.nodes.shape)
        _, R, M = self._rows.shape
        chunks, flat = -(-self.n // CHUNK), (self._rows.reshape(-1), self._factor.reshape(-1))
        _add_squares(chunks, self._uses, self._pattern, *flat, R, M, shared, values)
        return csr_array((values, self._indices, self._indptr), shape=(self.n * self.d, self.n * self.d))

    def _collect(self, squares: Sequence[ElementRows]) -> None:
        """Copy the coefficients and factors of all linear forms into one array, padded with zeros to whole SIMD blocks. The
        memory is reused, since allocation is slow.
        """
        used = _merged(squares)
        e, R, M = len(self._uses.nodes), sum(square.factor.shape[1] for square in used), self._uses.nodes.shape[1] * self.d
        if self._rows.shape[1] != R:
            self._rows, self._factor = np.zeros((e, R, -(-M // BLOCK) * BLOCK)), np.empty((e, R))
        at = 0
        for values, factor in used:
            here = slice(at, at + factor.shape[1])
            self._rows[:, here, :M], self._factor[:, here] = values, factor
            at = here.stop

    @property
    def structure(self) -> tuple[np.ndarray, np.ndarray]:
        """Return row pointers and column indices of the assembled matrices in scipy's CSR format."""
        return self._indptr, self._indices

    def links(self) -> csr_array:
        """Return the adjacency matrix of nodes that share an element, shape (n, n)."""
        column, first = self._pattern.column, self._pattern.first
        return csr_array((np.ones(len(column), np.int8), column, first), shape=(self.n, self.n))

    def upper(self, matrix: csr_array, free: np.ndarray, diagonal: np.ndarray) -> np.ndarray:
        """Return the entries on and above the diagonal of a symmetric matrix of this pattern. Rows and columns that are not
        free are set to zero, and `diagonal` is added to the diagonal. free: 1 for a free component, shape (n d,); diagonal:
        shape (n d,)."""
        row, column = self._row(), self._indices
        values = matrix.data * free[row] * free[column]
        values[row == column] += diagonal
        return np.asarray(values[column >= row])

    def symmetric(self, upper: np.ndarray) -> np.ndarray:
        """Return all entries of a symmetric matrix in CSR order. upper: its entries on and above the diagonal."""
        values = np.zeros(len(self._indices))
        values[self._indices >= self._row()] = upper
        half = csr_array((values, self._indices, self._indptr), shape=(self.n * self.d, self.n * self.d))
        values += half.T.tocsr().data  # the pattern is symmetric, so the numbers stand in the same order
        values[self._indices == self._row()] *= 0.5
        return values

    def _row(self) -> np.ndarray:
        """Return the row index of each stored entry of the matrix, shape (entries,)."""
        return np.repeat(np.arange(self.n * self.d, dtype=np.int32), np.diff(self._indptr))
