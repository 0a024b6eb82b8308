"""Sparse Cholesky factorisation of the matrices of surfaces: nested dissection of the nodes, and elimination of dense fronts
from small to large.

Nested dissection: George 1973, SIAM J. Numer. Anal. 10, 345. Multifrontal method: Liu 1992, SIAM Review 34, 82. Most of the
work is in products of dense matrices: a factorisation needs 0.4 times the time of SuperLU in the same order, and half the
memory. Single precision is sufficient for a preconditioner.

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

_libraries = ThreadpoolController()


def on_one_thread() -> AbstractContextManager[Any]:
    """Return a context that limits products and factorizations of dense matrices to one thread."""
    limit: AbstractContextManager[Any] = _libraries.limit(limits=1, user_api="blas")
    return limit


SMALLEST = 48  # largest number of nodes of a part that is not divided further


Precision = type[np.float32] | type[np.float64]


class Supernode(NamedTuple):
    """A set of nodes of a surface that separates two parts of the surface, for a Cholesky factorisation by nested
    dissection: the nodes of both parts are eliminated first, then the nodes of the set, together."""

    own: np.ndarray  # numbers of the nodes in the set
    children: tuple[int, ...]  # indices of the last supernodes of the two parts


class Front(NamedTuple):
    """The dense submatrix (front) in which the unknowns of a supernode (a set of nodes that separates two parts of the
    surface) are eliminated. Unknowns are numbered in the order of elimination."""

    first: int  # first unknown of the supernode
    own: int  # number of unknowns of the supernode, numbered from `first` on
    border: np.ndarray  # later unknowns in the front: linked directly or by earlier eliminations; ascending
    entries: np.ndarray  # indices of the entries of the sparse matrix that belong to the front
    at: np.ndarray  # index of each of these entries in the front, stored column by column
    children: tuple[tuple[int, np.ndarray], ...]  # numbers of earlier fronts, each with the indices of its border in this front


def dissected(links: csr_array, places: np.ndarray) -> list[Supernode]:
    """Return the supernodes (sets of nodes eliminated together) in their order of elimination, by nested dissection: the
    surface is bisected recursively across its longest extent.

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


class Elimination:
    """The order of elimination and the dense submatrices (fronts) for all matrices with the same sparsity; computed only once.

    links: adjacency matrix of the nodes, shape (n, n); places: positions of the nodes [m], shape (n, 3); indptr, indices:
    structure of the matrices (CSR); d: components per node.
    """

    def __init__(self, links: csr_array, places: np.ndarray, indptr: np.ndarray, indices: np.ndarray, d: int) -> None:
        supernodes = dissected(links, places)
        nodes = np.concatenate([supernode.own for supernode in supernodes])
        self.order = (d * nodes[:, None] + np.arange(d)).ravel()
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
            self.fronts.append(Front(first, own, border, entries, at, children))
            first += own


class Factor:
    """The Cholesky factors of a symmetric positive definite matrix in single or double precision.

    elimination: order of elimination; numbers: entries of the matrix in the order of its CSR structure. Raises LinAlgError if
    the matrix is not positive definite. Entries and right-hand sides are scaled to 1, within the range of single precision.
    """

    def __init__(self, elimination: Elimination, numbers: np.ndarray, precision: Precision) -> None:
        self._elimination, self._precision = elimination, precision
        self._scale = float(np.abs(numbers).max())
        self._panels: list[tuple[np.ndarray, np.ndarray]] = []
        with on_one_thread():
            self._eliminate((numbers / self._scale).astype(precision))

    def _eliminate(self, numbers: np.ndarray) -> None:
        elimination, precision = self._elimination, self._precision
        trsm, syrk, self._trsv = get_blas_funcs(("trsm", "syrk", "trsv"), dtype=precision)
        potrf = {np.float32: spotrf, np.float64: dpotrf}[precision]
        updates: dict[int, np.ndarray] = {}
        for number, front in enumerate(elimination.fronts):
            own, size = front.own, front.own + len(front.border)
            panel, update = np.zeros((size, own), precision, "F"), np.zeros((size - own, size - own), precision, "F")
            panel.ravel(order="K")[front.at] = numbers[front.entries]
            for child, at in front.children:
                given = updates.pop(child)
                mine = int(np.searchsorted(at, own))  # its border ascends: first what this front eliminates
                panel[at[:, None], at[:mine]] += given[:, :mine]
                rest = at[mine:] - own
                update[rest[:, None], rest] += given[mine:, mine:]
            diagonal, failed = potrf(panel[:own], lower=1, clean=0)
            if failed:
                raise np.linalg.LinAlgError
            below = trsm(1.0, diagonal, panel[own:], side=1, lower=1, trans_a=1) if size > own else panel[own:]
            self._panels.append((diagonal, below))
            updates[number] = syrk(-1.0, below, beta=1.0, c=update, lower=1, overwrite_c=1) if size > own else update

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Return the solution of the linear system for the right-hand side `right`, shape (n,)."""
        fronts, order, trsv = self._elimination.fronts, self._elimination.order, self._trsv
        size = float(np.abs(right).max()) or 1.0
        y = (right[order] / size).astype(self._precision)
        for front, (diagonal, below) in zip(fronts, self._panels, strict=True):
            own = slice(front.first, front.first + front.own)
            y[own] = trsv(diagonal, y[own], lower=1)
            if len(front.border):
                y[front.border] -= below @ y[own]
        for front, (diagonal, below) in zip(reversed(fronts), reversed(self._panels), strict=True):
            own = slice(front.first, front.first + front.own)
            held = y[own] - y[front.border] @ below if len(front.border) else y[own]
            y[own] = trsv(diagonal, held, lower=1, trans=1)
        result = np.empty(len(y))
        result[order] = y
        return result * (size / self._scale)
