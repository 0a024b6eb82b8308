"""Solver for the nodal velocities of a film described by a curve, which has few nodes with few neighbours each."""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix
from scipy.sparse.linalg import SuperLU, splu

from pellucid.bodies.fluid_film.forms.nodal_sums import ElementRows, SharedRows
from pellucid.bodies.fluid_film.solvers.contract import Border, Solution, System, refuse_driven

FREE = 1e-7  # resistance, relative to the largest, that counts as none: it is 1e-16 for motions without strain, else above 1e-5
UNBALANCED = 2e-3
"""Largest share of the loads that may act on motions without strain, as an effect of geometric errors. A uniform pressure
in a circle does no work on these motions. In the discrete geometry the share is 1.5e-3 if the node spacings vary randomly
by 1 %, as after redistribution; it is round-off for equal spacings, and 4e-3 with 8 nodes and 3e-5 with 20 nodes for
spacings that vary smoothly by a half."""


class CurveSolver:
    """Solves symmetric linear systems for the velocities of n nodes in d dimensions, assembled from elements with nodes (e,
    m). Components in the mask `held`, shape (n, d), are 0.
    """

    def __init__(self, nodes: np.ndarray, held: np.ndarray) -> None:
        n, d = held.shape
        self._size, self._shape, self._held = n * d, (n, d), held
        self._places = (d * nodes[:, :, None] + np.arange(d)).reshape(len(nodes), -1)
        self._rows = np.repeat(self._places, self._places.shape[1], axis=1).ravel()
        self._columns = np.tile(self._places, (1, self._places.shape[1])).ravel()

    def solve(self, system: System, borders: Sequence[Border]) -> Solution:
        known, stiffness = system.known, self._squares(system.stiffness)
        free = np.flatnonzero(~(known | self._held).ravel())
        resistance = self._squares(system.resistance)
        whole = resistance + stiffness
        v = np.where(known & ~self._held, system.velocity, 0.0).ravel()
        forces = system.force.ravel() + self._applied(stiffness, system.guess.ravel()) - self._applied(whole, v)
        right = forces[free]
        rows = np.array([border.row.ravel() for border in borders]).reshape(len(borders), self._size)
        goals = np.array([border.rate for border in borders]) - rows @ v
        sides = rows[:, free]
        if system.turning is None:
            found = _factors(self._matrix(whole, free, sides)).solve(np.concatenate([right, goals]))
            moved = found[: len(free)]
        else:
            squares = resistance, self._squares(system.turning), whole
            resisting, turning, matrix = (self._matrix(of, free).toarray() for of in squares)
            resisted, unresisted = _parted(resisting)
            self._check(system, unresisted, free, sides)
            basis = _least_turning(turning, resisted, unresisted)
            border = sides @ basis
            reduced = np.block([[basis.T @ matrix @ basis, border.T], [border, np.zeros((len(sides), len(sides)))]])
            found = np.linalg.solve(reduced, np.concatenate([basis.T @ right, goals]))
            moved = basis @ found[: basis.shape[1]]
        v[free] += moved
        return Solution(v.reshape(self._shape), -found[len(found) - len(borders) :])

    def _check(self, system: System, unresisted: np.ndarray, free: np.ndarray, sides: np.ndarray) -> None:
        """Raise IncompatibleLoad if the load does work on motions without resistance, and the constraints cannot balance it.

        unresisted: basis of these motions, in columns, for the components numbered in `free`; sides: coefficients of the
        linear constraints of these components, shape (k, free).
        """
        load, held = unresisted.T @ system.load.ravel()[free], unresisted.T @ sides.T
        if len(sides):
            load = load - held @ np.linalg.lstsq(held, load, rcond=FREE)[0]
        driven = np.zeros(self._size)
        driven[free] = unresisted @ load
        refuse_driven(system, driven.reshape(self._shape), UNBALANCED)

    def state_arrays(self) -> dict[str, np.ndarray]:
        return {}

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Do nothing: the solver has no state."""

    def _squares(self, rows: Sequence[ElementRows | SharedRows]) -> np.ndarray:
        """Return the element matrices Σ factor row ⊗ row, shape (e, m d, m d), from linear forms of the nodal velocities with
        coefficients `row` (`rows`: the linear forms).
        """
        found = [row.of_components(self._shape[1]) for row in rows]
        return np.asarray(sum(np.matmul((s.factor[..., None] * s.rows).transpose(0, 2, 1), s.rows) for s in found))

    def _applied(self, squares: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return the product of the sum of element matrices (`squares`, shape (e, m d, m d)) with the nodal velocities v, shape
        (n d,) both.
        """
        parts = np.matmul(squares, v[self._places][..., None])
        return np.bincount(self._places.ravel(), parts.ravel(), self._size)

    def _matrix(self, squares: np.ndarray, free: np.ndarray, sides: np.ndarray | None = None) -> csc_matrix:
        """Assemble element matrices (`squares`, shape (e, m d, m d)) into a sparse matrix of the components numbered in `free`.

        sides: coefficients of the linear constraints of these components, shape (k, free), which are added as rows and columns.
        """
        number = np.full(self._size, -1)
        number[free] = np.arange(len(free))
        rows, columns = number[self._rows], number[self._columns]
        kept = (rows >= 0) & (columns >= 0)
        rows, columns, values, size = rows[kept], columns[kept], squares.ravel()[kept], len(free)
        if sides is not None and len(sides):
            side, place = (index.ravel() for index in np.indices(sides.shape))
            rows = np.concatenate([rows, size + side, place])
            columns = np.concatenate([columns, place, size + side])
            values = np.concatenate([values, sides.ravel(), sides.ravel()])
            size += len(sides)
        return coo_matrix((values, (rows, columns)), (size, size)).tocsc()


def _factors(matrix: csc_matrix) -> SuperLU:
    """Return the LU factors of a matrix. Raises LinAlgError, as for dense matrices, if it is singular."""
    try:
        return splu(matrix)
    except RuntimeError as error:
        if "singular" not in str(error):
            raise
        raise np.linalg.LinAlgError(str(error)) from error


def _parted(resistance: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return orthonormal bases, in columns, of the motions that have resistance and of those that have none.

    resistance: dense matrix of the resistance, shape (free, free), for the components that are not prescribed.
    """
    values, modes = np.linalg.eigh(resistance)
    free = values < FREE * values[-1]
    return modes[:, ~free], modes[:, free]


def _least_turning(turning: np.ndarray, resisted: np.ndarray, unresisted: np.ndarray) -> np.ndarray:
    """Return a basis, in columns, of the motions that rotate the film least among all motions with the same strain rates.

    turning: matrix of the measure of rotation ∫ |∇v_n|² dA; resisted, unresisted: bases of the motions with and without
    resistance, in columns.
    """
    turns, ways = np.linalg.eigh(unresisted.T @ turning @ unresisted)
    turned = turns > FREE * np.abs(turning).max()  # translations turn nothing
    ways = unresisted @ ways[:, turned]
    return np.asarray(resisted - ways @ ((ways.T @ turning @ resisted) / turns[turned, None]))
