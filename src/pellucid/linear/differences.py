"""Derivatives of forces on the nodes of a body with respect to their positions, by differences of forces of whole groups of
nodes.

The force on a node depends on the positions of a few nodes only, its links. Nodes with no link to a common node form a group:
each force depends on at most one node of the group, so that one difference of the forces contains the derivatives with
respect to all of them (Curtis, Powell & Reid 1974, IMA J. Appl. Math. 13, 117). The number of groups does not grow with the
number of nodes.
"""

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.sparse import csr_array

from pellucid.jit import kernel


class GroupedDifferences:
    """Derivatives of the forces on n nodes with respect to their positions.

    links: adjacency matrix of the nodes with sorted indices, symmetric and with the diagonal, shape (n, n): the force on a
    node depends on the positions of its links; step: difference of a coordinate [m].
    """

    def __init__(self, links: csr_array, step: float) -> None:
        n = len(links.indptr) - 1
        self._step = step
        near = csr_array(links @ links)
        group = np.full(n, -1)
        _group(near.indptr, near.indices, group, np.full(n, -1))
        row, column = np.repeat(np.arange(n), np.diff(links.indptr)), links.indices
        self._members = [np.flatnonzero(group == number) for number in range(group.max() + 1)]
        order = np.argsort(group[column], kind="stable")
        ends = np.searchsorted(group[column][order], np.arange(len(self._members) + 1))
        self._pairs = [order[ends[k] : ends[k + 1]] for k in range(len(self._members))]
        self._row = row
        self._back = np.searchsorted(row * n + column, column * n + row)  # pair (j, i) of each pair (i, j)

    def find(self, forces: Callable[[np.ndarray], np.ndarray], position: np.ndarray) -> np.ndarray:
        """Return the symmetric part of -∂f/∂x for each pair of linked nodes [N/m], shape (pairs, 3, 3), by central differences.

        forces: function that returns the forces [N], shape (n, 3), for positions [m], shape (n, 3); position: [m], shape
        (n, 3).
        """
        found, x = np.zeros((len(self._row), 3, 3)), position.copy()
        for members, pairs in zip(self._members, self._pairs, strict=True):
            for axis in range(3):
                here = position[members, axis]
                x[members, axis] = here + self._step
                above = forces(x).copy()
                x[members, axis] = here - self._step
                change = (forces(x) - above) / (2.0 * self._step)
                x[members, axis] = here
                found[pairs, :, axis] = change[self._row[pairs]]
        return np.asarray(0.5 * (found + found[self._back].transpose(0, 2, 1)))


@kernel()
def _group(indptr: Any, indices: Any, group: Any, taken: Any) -> None:
    """Assign to each node the number of the first group without a node that is linked to it, in the order of the nodes.

    indptr, indices: links (CSR); group: numbers of the groups, -1 at the start; taken: node for which a group was last seen
    among the links, -1 at the start.
    """
    for a in range(len(group)):
        for k in range(indptr[a], indptr[a + 1]):
            if group[indices[k]] >= 0:
                taken[group[indices[k]]] = a
        number = 0
        while taken[number] == a:
            number += 1
        group[a] = number
