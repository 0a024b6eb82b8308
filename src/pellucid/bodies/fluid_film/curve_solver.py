"""Velocities of a film that a curve describes: few nodes, each with few neighbours."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, hstack, vstack
from scipy.sparse.linalg import splu

from pellucid.bodies.fluid_film.nodal_sums import Rows, SharedRows
from pellucid.bodies.fluid_film.solver import INCOMPATIBLE, Border, IncompatibleLoad, Solution, System

FREE = 1e-7  # of the largest resistance: less has none. Motions of a curve without strain have 1e-16, others above 1e-5


class CurveSolver:
    """Symmetric systems of elements with nodes (e, m), n in all, in d dimensions; components that are `held` are 0."""

    def __init__(self, nodes: np.ndarray, held: np.ndarray) -> None:
        n, d = held.shape
        self._size, self._shape, self._held = n * d, (n, d), held
        places = (d * nodes[:, :, None] + np.arange(d)).reshape(len(nodes), -1)
        self._rows = np.repeat(places, places.shape[1], axis=1).ravel()
        self._columns = np.tile(places, (1, places.shape[1])).ravel()

    def solve(self, system: System, borders: Sequence[Border]) -> Solution:
        """See `pellucid.bodies.fluid_film.solver`."""
        known, stiffness = system.known, self._whole(system.stiffness)
        free = np.flatnonzero(~(known | self._held).ravel())
        resistance = self._whole(system.resistance)
        whole = resistance + stiffness
        v = np.where(known & ~self._held, system.velocity, 0.0).ravel()
        forces = system.force.ravel() + stiffness @ system.guess.ravel() - whole @ v
        right = forces[free]
        rows = np.array([border.row.ravel() for border in borders]).reshape(len(borders), self._size)
        goals = np.array([border.rate for border in borders]) - rows @ v
        matrix, sides = whole[free][:, free], rows[:, free]
        if system.turning is None:
            found = splu(csc_matrix(_bordered(matrix, sides))).solve(np.concatenate([right, goals]))
            moved = found[: len(free)]
        else:
            dense = [of[free][:, free].toarray() for of in (resistance, self._whole(system.turning))]
            basis = _resisted(dense[0], dense[1], right, float(np.linalg.norm(forces)))
            reduced = _bordered(csc_matrix(basis.T @ matrix @ basis), sides @ basis).toarray()
            found = np.linalg.solve(reduced, np.concatenate([basis.T @ right, goals]))
            moved = basis @ found[: basis.shape[1]]
        v[free] += moved
        return Solution(v.reshape(self._shape), -found[len(found) - len(borders) :])

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Nothing."""
        return {}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """It keeps nothing."""

    def _whole(self, squares: Sequence[Rows | SharedRows]) -> csc_matrix:
        found = [square.of_components(self._shape[1]) for square in squares]
        parts = [np.matmul((s.factor[..., None] * s.rows).transpose(0, 2, 1), s.rows) for s in found]
        elements = np.sum(parts, axis=0)
        return coo_matrix((elements.ravel(), (self._rows, self._columns)), (self._size, self._size)).tocsc()


def _bordered(matrix: csc_matrix, sides: np.ndarray) -> csc_matrix:
    if not len(sides):
        return matrix
    rows = csc_matrix(sides)
    return csc_matrix(vstack([hstack([matrix, rows.T]), hstack([rows, csc_matrix((len(sides), len(sides)))])]))


def _resisted(resistance: np.ndarray, turning: np.ndarray, right: np.ndarray, size: float) -> np.ndarray:
    """A basis of the motions that meet resistance and, of all with their strain rates, turn the film least.

    size: of the forces [N], those on components that are prescribed among them. Raises IncompatibleLoad where the forces drive
    motions that meet none.
    """
    values, modes = np.linalg.eigh(resistance)
    free = values < FREE * values[-1]
    resisted, unresisted = modes[:, ~free], modes[:, free]
    if np.linalg.norm(unresisted.T @ right) > INCOMPATIBLE * size:
        raise IncompatibleLoad
    turns, ways = np.linalg.eigh(unresisted.T @ turning @ unresisted)
    turned = turns > FREE * np.abs(turning).max()  # translations turn nothing
    ways = unresisted @ ways[:, turned]
    return np.asarray(resisted - ways @ ((ways.T @ turning @ resisted) / turns[turned, None]))
