"""Velocities of a film of few nodes, as of a curve, by dense factorisations."""

from collections.abc import Mapping, Sequence

import numpy as np

from pellucid.bodies.fluid_film.assembly import Rows
from pellucid.bodies.fluid_film.solver import INCOMPATIBLE, Border, IncompatibleLoad, Solution, System

FREE = 1e-7  # of the largest resistance: less has none. Motions of a curve without strain have 1e-16, others above 1e-5


class DenseSolver:
    """Symmetric systems of elements with nodes (e, m), n in all, in d dimensions; components that are `held` are 0."""

    def __init__(self, nodes: np.ndarray, held: np.ndarray) -> None:
        n, d = held.shape
        self._size, self._shape = n * d, (n, d)
        self._places = (d * nodes[:, :, None] + np.arange(d)).reshape(len(nodes), -1)
        self._held = held

    def solve(self, system: System, borders: Sequence[Border]) -> Solution:
        """See `pellucid.bodies.fluid_film.solver`."""
        A, G = self._whole(system.resistance), self._whole(system.stiffness)
        free = ~(system.known | self._held).ravel()
        v = np.where(system.known, system.velocity, 0.0).ravel()
        right = (system.force.ravel() + G @ system.guess.ravel() - (A + G) @ v)[free]
        A, G = A[np.ix_(free, free)], G[np.ix_(free, free)]
        rows = np.array([border.row.ravel() for border in borders]).reshape(len(borders), self._size)
        goals = np.array([border.rate for border in borders]) - rows @ v
        rows, basis = rows[:, free], np.eye(int(free.sum()))
        if system.turning is not None:
            basis = _resisted(A, self._whole(system.turning)[np.ix_(free, free)], right)
        reduced, sides, k = basis.T @ (A + G) @ basis, rows @ basis, len(borders)
        whole = np.block([[reduced, sides.T], [sides, np.zeros((k, k))]])
        found = np.linalg.solve(whole, np.concatenate([basis.T @ right, goals]))
        v[free] += basis @ found[: basis.shape[1]]
        return Solution(v.reshape(self._shape), -found[basis.shape[1] :])

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Nothing."""
        return {}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """It keeps nothing."""

    def _whole(self, squares: Sequence[Rows]) -> np.ndarray:
        whole = np.zeros((self._size, self._size))
        elements = sum(np.matmul((s.factor[..., None] * s.rows).transpose(0, 2, 1), s.rows) for s in squares)
        np.add.at(whole, (self._places[:, :, None], self._places[:, None, :]), elements)
        return whole


def _resisted(A: np.ndarray, turning: np.ndarray, right: np.ndarray) -> np.ndarray:
    """A basis of the motions that meet resistance and, of all with their strain rates, turn the film least.

    Raises IncompatibleLoad where the forces drive motions that meet none.
    """
    values, modes = np.linalg.eigh(A)
    free = values < FREE * values[-1]
    resisted, unresisted = modes[:, ~free], modes[:, free]
    if np.linalg.norm(unresisted.T @ right) > INCOMPATIBLE * np.linalg.norm(right):
        raise IncompatibleLoad
    added = np.linalg.lstsq(unresisted.T @ turning @ unresisted, unresisted.T @ turning @ resisted, rcond=FREE)[0]
    return np.asarray(resisted - unresisted @ added)
