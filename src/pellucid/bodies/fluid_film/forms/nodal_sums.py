"""Sums of element contributions at the nodes of a film, and values of linear forms of nodal velocities in its elements.

Every node sums the contributions of its elements in a fixed order, so that results do not depend on the number of threads.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from pellucid.jit.loops import parallel_loop

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
