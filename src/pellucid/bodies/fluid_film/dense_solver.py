"""Velocities of a film of few nodes, as of a curve, by dense factorisations."""

from collections.abc import Sequence

import numpy as np

from pellucid.bodies.fluid_film.solver import Border, IncompatibleLoad, Solution

FREE = 1e-7  # of the largest resistance: less has none. Motions of a curve without strain have 1e-16, others above 1e-5
INCOMPATIBLE = 0.02  # of the forces, that motions without resistance may feel by the error of the geometry


class DenseSolver:
    """Symmetric systems of elements with nodes (e, m), n in all, in d dimensions; components that are `held` are 0."""

    def __init__(self, nodes: np.ndarray, held: np.ndarray) -> None:
        n, d = held.shape
        self._size, self._shape = n * d, (n, d)
        self._places = (d * nodes[:, :, None] + np.arange(d)).reshape(len(nodes), -1)
        self._held = held

    def solve(
        self,
        resistance: np.ndarray,
        stiffness: np.ndarray,
        force: np.ndarray,
        guess: np.ndarray,
        borders: Sequence[Border],
        known: np.ndarray,
        velocity: np.ndarray,
        turning: np.ndarray | None,
    ) -> Solution:
        """See `pellucid.bodies.fluid_film.solver`."""
        A, G = self._whole(resistance), self._whole(stiffness)
        free = ~(known | self._held).ravel()
        v = np.where(known, velocity, 0.0).ravel()
        right = (force.ravel() + G @ guess.ravel() - (A + G) @ v)[free]
        A, G = A[np.ix_(free, free)], G[np.ix_(free, free)]
        rows = np.array([border.row.ravel() for border in borders]).reshape(len(borders), self._size)
        goals = np.array([border.rate for border in borders]) - rows @ v
        rows, basis = rows[:, free], np.eye(int(free.sum()))
        if turning is not None:
            basis = _resisted(A, self._whole(turning)[np.ix_(free, free)], right)
        reduced, sides, k = basis.T @ (A + G) @ basis, rows @ basis, len(borders)
        whole = np.block([[reduced, sides.T], [sides, np.zeros((k, k))]])
        found = np.linalg.solve(whole, np.concatenate([basis.T @ right, goals]))
        v[free] += basis @ found[: basis.shape[1]]
        return Solution(v.reshape(self._shape), -found[basis.shape[1] :])

    def _whole(self, elements: np.ndarray) -> np.ndarray:
        whole = np.zeros((self._size, self._size))
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
