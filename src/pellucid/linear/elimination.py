"""Sparse factorisation of symmetric matrices whose unknowns belong to nodes in space: nested dissection of the nodes, and
elimination of dense fronts from small to large.

Nested dissection: George 1973, SIAM J. Numer. Anal. 10, 345. Multifrontal method: Liu 1992, SIAM Review 34, 82. Most of the
work is in products of dense matrices: a factorisation needs 0.4 times the time of SuperLU in the same order, and half the
memory. Single precision is often sufficient for a preconditioner.

Positive definite matrices have a Cholesky factorisation L Lᵀ. Quasi-definite matrices [K Bᵀ; B -C], with K and C positive
definite, have a factorisation L S Lᵀ in every order of elimination, without pivoting (Vanderbei 1995, SIAM J. Optim. 5, 100);
S has 1 on its diagonal for the unknowns of K and -1 for those of C, such as pressures.

The libraries of numpy and scipy run on one thread: with several, their results depend on the number of threads, and small
matrices take longer.
"""

from contextlib import AbstractContextManager
from typing import Any, NamedTuple

import numpy as np
import scipy.linalg  # noqa: F401  its library is not numpy's, and must be loaded when the controller looks for them
from scipy.linalg.blas import get_blas_funcs
from scipy.linalg.lapack import dpotrf, spotrf
from scipy.sparse import csr_array
from threadpoolctl import ThreadpoolController

from pellucid.jit import kernel

_libraries = ThreadpoolController()


def on_one_thread() -> AbstractContextManager[Any]:
    """Return a context that limits products and factorizations of dense matrices to one thread."""
    limit: AbstractContextManager[Any] = _libraries.limit(limits=1, user_api="blas")
    return limit


SMALLEST = 48  # largest number of nodes of a part that is not divided further


Precision = type[np.float32] | type[np.float64]


class Supernode(NamedTuple):
    """A set of nodes that separates two parts of a body, for a factorisation by nested dissection: the nodes of both parts
    are eliminated first, then the nodes of the set, together."""

    own: np.ndarray  # numbers of the nodes in the set
    children: tuple[int, ...]  # indices of the last supernodes of the two parts


class Front(NamedTuple):
    """The dense submatrix (front) in which the unknowns of a supernode (a set of nodes that separates two parts of a body)
    are eliminated. Unknowns are numbered in the order of elimination."""

    first: int  # first unknown of the supernode
    own: int  # number of unknowns of the supernode, numbered from `first` on
    positive: int  # number of these unknowns with a positive pivot, which come first; the others have a negative one
    border: np.ndarray  # later unknowns in the front: linked directly or by earlier eliminations; ascending
    entries: np.ndarray  # indices of the entries of the sparse matrix that belong to the front
    at: np.ndarray  # index of each of these entries in the front, stored column by column
    children: tuple[tuple[int, np.ndarray], ...]  # numbers of earlier fronts, each with the indices of its border in this front


def dissected(links: csr_array, places: np.ndarray) -> list[Supernode]:
    """Return the supernodes (sets of nodes eliminated together) in their order of elimination, by nested dissection: the
    body is bisected recursively across its longest extent.

    links: adjacency matrix of the nodes, shape (n, n); places: positions of the nodes [m], shape (n, 3).
    """
    supernodes: list[Supernode] = []
    beyond = np.zeros(len(places), np.int8)

    def divide(nodes: np.ndarray) -> int:
        own: np.ndarray = nodes
        children: tuple[int, ...] = ()
        if len(nodes) > SMALLEST:
            along = int(np.ptp(places[nodes], axis=0).argmax())
            order = np.argsort(places[nodes, along], kind="stable")
            near, far = nodes[order[: len(nodes) // 2]], nodes[order[len(nodes) // 2 :]]
            beyond[far] = 1
            touches = (links[near] @ beyond) > 0
            beyond[far] = 0
            own, halves = near[touches], (near[~touches], far)
            if not len(own):  # nothing links them: one node is enough to keep them apart
                own, halves = near[:1], (near[1:], far)
            children = tuple(divide(half) for half in halves if len(half))
        supernodes.append(Supernode(own, children))
        return len(supernodes) - 1

    divide(np.arange(len(places)))
    return supernodes


class FactorSize(NamedTuple):
    """Size of the factors of a matrix, and effort of the factorisation."""

    numbers: float  # number of entries of the factors
    operations: float  # number of multiplications and additions


def factor_size(links: csr_array, places: np.ndarray, d: int) -> FactorSize:
    """Return the size of the factors of a symmetric matrix with d unknowns per node, without computing them.

    links: adjacency matrix of the nodes, shape (n, n); places: positions of the nodes [m], shape (n, 3).
    """
    numbers = operations = 0.0
    when, borders = np.empty(len(places), np.int64), list[np.ndarray]()
    supernodes = dissected(links, places)
    for number, supernode in enumerate(supernodes):
        when[supernode.own] = number
    for number, supernode in enumerate(supernodes):
        linked = [links.indices[links.indptr[node] : links.indptr[node + 1]] for node in supernode.own]
        border = np.unique(np.concatenate([*linked, *(borders[child] for child in supernode.children)]))
        borders.append(border[when[border] > number])
        own, size = d * len(supernode.own), d * (len(supernode.own) + len(borders[-1]))
        numbers += own * (size - 0.5 * own)
        operations += own * size * (size - own) + own**3 / 3.0
    return FactorSize(numbers, operations)


class Elimination:
    """The order of elimination and the dense submatrices (fronts) for all matrices with the same sparsity; computed only once.

    links: adjacency matrix of the nodes, shape (n, n); places: positions of the nodes [m], shape (n, 3); indptr, indices:
    structure of the matrices (CSR); d: unknowns per node; negative: number of unknowns per node with negative pivots, which
    are the last of each node (0 for positive definite matrices).
    """

    def __init__(
        self, links: csr_array, places: np.ndarray, indptr: np.ndarray, indices: np.ndarray, d: int, negative: int = 0
    ) -> None:
        supernodes = dissected(links, places)
        of_node = np.arange(d - negative), np.arange(d - negative, d)
        self.order = np.concatenate(
            [(d * supernode.own[:, None] + each).ravel() for supernode in supernodes for each in of_node]
        )
        self.signs = None if negative == 0 else np.where(self.order % d < d - negative, 1, -1).astype(np.int8)
        """Signs of the pivots in the order of elimination; None if all are positive."""
        place = np.empty(len(self.order), np.int64)
        place[self.order] = np.arange(len(self.order))
        self.fronts: list[Front] = []
        first = 0
        local = np.empty(len(self.order), np.int64)
        for supernode in supernodes:
            own = d * len(supernode.own)
            rows = self.order[first : first + own]
            counts = indptr[rows + 1] - indptr[rows]
            entries = np.repeat(indptr[rows] - np.concatenate([[0], np.cumsum(counts)[:-1]]), counts) + np.arange(counts.sum())
            column, row = place[indices[entries]], np.repeat(np.arange(own), counts)
            lower = column >= first + row
            entries, column, row = entries[lower], column[lower], row[lower]
            found = [column, *(self.fronts[child].border for child in supernode.children)]
            border = np.unique(np.concatenate(found))
            border = border[border >= first + own]
            local[first : first + own] = np.arange(own)
            local[border] = own + np.arange(len(border))
            children = tuple((child, local[self.fronts[child].border]) for child in supernode.children)
            at = row * (own + len(border)) + local[column]
            self.fronts.append(Front(first, own, (d - negative) * len(supernode.own), border, entries, at, children))
            first += own


@kernel()
def _add(given: Any, at: Any, own: Any, panel: Any, update: Any) -> None:
    """Add the lower triangle of the update `given` of an earlier front to the columns of a front; all arrays are transposed.

    at: index in the front of each row of `given`, ascending; own: number of unknowns that the front eliminates, whose columns
    are in `panel`; the others are in `update`.
    """
    n = len(at)
    for j in range(n):
        column = at[j]
        if column < own:
            for i in range(j, n):
                panel[column, at[i]] += given[j, i]
        else:
            for i in range(j, n):
                update[column - own, at[i] - own] += given[j, i]


def _eliminated(panel: np.ndarray, positive: int, update: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Eliminate the unknowns of a front. Returns the lower triangle of the factor L for these unknowns, shape (own, own), its
    rows below, and the update with the contribution of these unknowns to all later ones, of which the lower triangle counts.

    panel: columns of these unknowns, shape (size, own); positive: number of positive pivots, which come first; update:
    contributions of earlier unknowns, shape (size - own, size - own). Raises LinAlgError if a pivot has the wrong sign.
    """
    trsm, syrk, gemm = get_blas_funcs(("trsm", "syrk", "gemm"), (panel,))
    size, own = panel.shape
    diagonal = _cholesky(panel[:positive, :positive])
    below = panel[positive:, :positive]
    if size > positive:
        below = trsm(1.0, diagonal, below, side=1, lower=1, trans_a=1)
    if positive < own:  # L = [L₁ 0; X L₂] with X L₁ᵀ = B and L₂ L₂ᵀ = C + X Xᵀ
        X, below = below[: own - positive], below[own - positive :]
        last = _cholesky(syrk(1.0, X, beta=-1.0, c=panel[positive:own, positive:], lower=1))
        whole = np.zeros((own, own), panel.dtype, "F")
        whole[:positive, :positive], whole[positive:, :positive], whole[positive:, positive:] = diagonal, X, last
        diagonal = whole
        if size > own:
            rest = gemm(1.0, below, X, beta=-1.0, c=panel[own:, positive:], trans_b=1)
            negative = trsm(1.0, last, rest, side=1, lower=1, trans_a=1)
            update = syrk(1.0, negative, beta=1.0, c=update, lower=1, overwrite_c=1)
            update = syrk(-1.0, below, beta=1.0, c=update, lower=1, overwrite_c=1)
            below = np.hstack([below, negative])
        return diagonal, below if size > own else panel[own:], update
    return diagonal, below, syrk(-1.0, below, beta=1.0, c=update, lower=1, overwrite_c=1) if size > own else update


def _cholesky(matrix: np.ndarray) -> np.ndarray:
    """Return the Cholesky factor in the lower triangle; raises LinAlgError if the matrix is not positive definite."""
    factor, failed = (dpotrf if matrix.dtype == np.float64 else spotrf)(matrix, lower=1, clean=0)
    if failed:
        raise np.linalg.LinAlgError
    return np.asarray(factor)


class Factor:
    """The factors of a symmetric matrix, positive definite or quasi-definite (see the module), in single or double precision.

    elimination: order of elimination, with the number of negative pivots; numbers: entries of the matrix in the order of its
    CSR structure. Raises LinAlgError if the matrix is not of this kind. Entries and right-hand sides are scaled to 1, within
    the range of single precision.
    """

    def __init__(self, elimination: Elimination, numbers: np.ndarray, precision: Precision) -> None:
        self._elimination, self._precision = elimination, precision
        self._scale = float(np.abs(numbers).max())
        self._panels: list[tuple[np.ndarray, np.ndarray]] = []
        with on_one_thread():
            self._eliminate((numbers / self._scale).astype(precision))

    def _eliminate(self, numbers: np.ndarray) -> None:
        precision = self._precision
        updates: dict[int, np.ndarray] = {}
        for number, front in enumerate(self._elimination.fronts):
            own, size = front.own, front.own + len(front.border)
            panel, update = np.zeros((size, own), precision, "F"), np.zeros((size - own, size - own), precision, "F")
            panel.ravel(order="K")[front.at] = numbers[front.entries]
            for child, at in front.children:
                given = updates.pop(child)
                _add(given.T, at, own, panel.T, update.T)
            diagonal, below, updates[number] = _eliminated(panel, front.positive, update)
            self._panels.append((diagonal, below))

    def pivots(self) -> np.ndarray:
        """Return the absolute pivots of the unknowns, shape (n,): the stiffness of each with the later ones held."""
        found = np.empty(len(self._elimination.order))
        for front, (diagonal, _) in zip(self._elimination.fronts, self._panels, strict=True):
            own = slice(front.first, front.first + front.own)
            found[self._elimination.order[own]] = self._scale * np.diagonal(diagonal).astype(float) ** 2
        return found

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Return the solution of the linear system for the right-hand side `right`, shape (n,)."""
        fronts, order = self._elimination.fronts, self._elimination.order
        trsv = get_blas_funcs("trsv", dtype=self._precision)
        size = float(np.abs(right).max()) or 1.0
        y = (right[order] / size).astype(self._precision)
        for front, (diagonal, below) in zip(fronts, self._panels, strict=True):
            own = slice(front.first, front.first + front.own)
            y[own] = trsv(diagonal, y[own], lower=1)
            if len(front.border):
                y[front.border] -= below @ y[own]
        if self._elimination.signs is not None:
            y *= self._elimination.signs
        for front, (diagonal, below) in zip(reversed(fronts), reversed(self._panels), strict=True):
            own = slice(front.first, front.first + front.own)
            held = y[own] - y[front.border] @ below if len(front.border) else y[own]
            y[own] = trsv(diagonal, held, lower=1, trans=1)
        result = np.empty(len(y))
        result[order] = y
        return result * (size / self._scale)
