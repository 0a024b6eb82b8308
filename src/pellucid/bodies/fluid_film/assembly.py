"""Linear forms of the nodal velocities of a film's elements, their sums at the nodes, and the symmetric sparse matrices that
are assembled from them as Σ factor row ⊗ row (row: the coefficients of a form, see `ElementRows`). Such a matrix has no
negative eigenvalue if no factor is negative.

Every node sums the contributions of its elements in a fixed order, so that results do not depend on the number of threads.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.jit import kernel
from pellucid.jit.loops import parallel_loop
from pellucid.jit.memory import zeros
from pellucid.jit.vector import LANES, load, splat, spread, store

CHUNK = 256  # nodes or elements


class ElementRows(NamedTuple):
    """r linear forms row · v of the nodal vectors v of each of e elements, for example strain rates, each with a weight
    `factor`. They define quadratic forms Σ factor (row · v)², such as the dissipation, and nodal forces Σ factor row.
    Elements have m nodes, vectors d components."""

    rows: np.ndarray  # (e, r, m d) coefficients
    factor: np.ndarray  # (e, r) weights, e.g. viscosity times area

    def of_components(self, d: int) -> "ElementRows":
        """Return self: these coefficients already refer to d components per node."""
        return self


def rows(values: np.ndarray, factor: np.ndarray) -> ElementRows:
    """Build `ElementRows` from the coefficients of linear forms, shape (e, ..., m, d), and factors that broadcast to shape (e,
    ...).
    """
    e, (m, d) = len(values), values.shape[-2:]
    whole = np.array(np.broadcast_to(factor, values.shape[:-2]), dtype=float)  # kernels want writable arrays: one type for all
    return ElementRows(np.ascontiguousarray(values.reshape(e, -1, m * d)), whole.reshape(e, -1))


class SharedRows(NamedTuple):
    """r linear forms row · s of scalars s at the m nodes of each of e elements, each with a weight `factor`, which define
    quadratic forms Σ factor (row · s)². A form is applied to each component of the nodal vectors separately."""

    rows: np.ndarray  # (e, r, m) coefficients
    factor: np.ndarray  # (e, r) weights, e.g. drag coefficient times area

    def of_components(self, d: int) -> ElementRows:
        """Return these linear forms as `ElementRows`: one form for each of the d components of the nodal vectors."""
        return rows(self.rows[:, :, None, :, None] * np.eye(d)[:, None, :], self.factor[..., None])


class Uses(NamedTuple):
    """For each node, the list of the elements that contain the node; used to sum contributions of elements at the nodes."""

    nodes: np.ndarray  # (e, m) nodes of the elements
    d: int  # components per node
    first: np.ndarray  # (n + 1,) index in `use` of the first entry of each node
    use: np.ndarray  # entries of node i from first[i] on: m e + a for each element e whose node a is node i, ascending


def uses(nodes: np.ndarray, n: int, d: int) -> Uses:
    """Return index lists of the elements that contain each of n nodes. nodes: nodes of the elements, shape (e, m); d:
    components per node.
    """
    first = np.concatenate([[0], np.cumsum(np.bincount(nodes.ravel(), minlength=n))])
    return Uses(np.ascontiguousarray(nodes), d, first, np.argsort(nodes.ravel(), kind="stable"))


@parallel_loop()
def _add_rows(chunk, form, parts):
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(parts))):
        for r in range(form.factor.shape[1]):
            factor = form.factor[e, r]
            for k in range(parts.shape[1]):
                parts[e, k] += factor * form.rows[e, r, k]


@parallel_loop()
def _gather(chunk, uses, parts, result):
    m, d = uses.nodes.shape[1], uses.d
    for i in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(result))):
        for u in range(uses.first[i], uses.first[i + 1]):
            e, a = uses.use[u] // m, uses.use[u] % m
            for c in range(d):
                result[i, c] += parts[e, d * a + c]


@parallel_loop()
def _find_rates(chunk, uses, form, v, rates):
    nodes, d = uses.nodes, uses.d
    for e in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(nodes))):
        for r in range(form.rows.shape[1]):
            rate = 0.0
            for a in range(nodes.shape[1]):
                for c in range(d):
                    rate += form.rows[e, r, d * a + c] * v[nodes[e, a], c]
            rates[e, r] = rate


class NodalSums:
    """Sums element contributions at n nodes with d components each. nodes: nodes of the elements, shape (e, m)."""

    def __init__(self, nodes: np.ndarray, n: int, d: int) -> None:
        self.n, self.d, self._uses = n, d, uses(nodes, n, d)

    def gathered(self, forms: Sequence[ElementRows]) -> np.ndarray:
        """Return the sum of factor · row over all linear forms of all elements, at the nodes: shape (n, d)."""
        e, m = self._uses.nodes.shape
        parts = np.zeros((e, m * self.d))
        for form in forms:
            _add_rows(-(-e // CHUNK), form, parts)
        return self.summed(parts)

    def summed(self, parts: np.ndarray) -> np.ndarray:
        """Sum element contributions, shape (e, m, d) or (e, m d), at each node: shape (n, d)."""
        result = np.zeros((self.n, self.d))
        _gather(-(-self.n // CHUNK), self._uses, np.ascontiguousarray(parts.reshape(len(parts), -1)), result)
        return result

    def rates(self, form: ElementRows, v: np.ndarray) -> np.ndarray:
        """Return the value of every linear form of each element, shape (e, r), for nodal vectors v, shape (n, d). The factors
        of the forms are not applied.
        """
        result = np.empty(form.factor.shape)
        _find_rates(-(-len(self._uses.nodes) // CHUNK), self._uses, form, np.ascontiguousarray(v), result)
        return result


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
