"""The linear system of a film, whose solution is its nodal velocities, and the solvers for curves, which have few nodes with
few neighbours each, and for surfaces.

Surfaces: conjugate gradients with earlier Cholesky factors as preconditioner. The matrix changes little from step to step, so
its factors serve for many steps; they are recomputed when the saved iterations exceed the cost. They are in single precision,
with half the time and memory, until a new factor needs as many iterations as an old one. Constraints C v = c hold in every
iteration: directions and residuals are projected by P = I - Z (C Z)⁻¹ C and its transpose, with any vectors Z for which C Z is
invertible (Gould, Hribar & Nocedal 2001, SIAM J. Sci. Comput. 23, 1376). Motions R without resistance are removed in the same
way, with Z = R and C = Rᵀ times the areas of the nodes; on a closed surface these are the rigid motions.
"""

from collections.abc import Mapping, Sequence
from math import pi
from typing import NamedTuple, Protocol

import numpy as np
from scipy.sparse import coo_matrix, csc_matrix, csr_array
from scipy.sparse.linalg import SuperLU, splu

from pellucid.bodies.fluid_film.assembly import Assembly, ElementRows, SharedRows
from pellucid.linear.elimination import Elimination, Factor


class IncompatibleLoad(Exception):
    """The loads do work on motions without resistance, so that no velocity balances them.

    driven: forces of the loads on these motions [N], shape (n, d).
    """

    def __init__(self, driven: np.ndarray) -> None:
        super().__init__("a load drives motions without resistance")
        self.driven = driven


class Border(NamedTuple):
    """A linear constraint row · v = rate of the nodal velocities v."""

    row: np.ndarray  # (n, d) coefficients
    rate: float  # prescribed value of row · v


class Solution(NamedTuple):
    """Solution of the linear system of a film: nodal velocities, and the k factors of the linear constraints. The
    constraint forces on the nodes are the sum of each factor times the coefficients of its constraint (`Border.row`)."""

    velocity: np.ndarray  # (n, d) nodal velocities [m/s]
    border_forces: np.ndarray  # (k,) e.g. pressure [Pa] for a constraint of the volume


class System(NamedTuple):
    """The linear system (R + S) v = f + S g for the nodal velocities v of a film with nodes at x.

    R, the resistance, and S, the stiffness, are sums of squares of linear forms (`ElementRows`); f are the forces and g is a
    first velocity estimate.
    """

    x: np.ndarray  # (n, d) nodal positions [m]
    area: np.ndarray  # (n,) area of the film at each node [m²]
    resistance: Sequence[ElementRows | SharedRows]  # R [N s/m]
    stiffness: Sequence[ElementRows]  # S [N s/m]
    force: np.ndarray  # (n, d) f [N]
    load: np.ndarray  # (n, d) external part of f [N]; the internal part does no work on rigid motions
    guess: np.ndarray  # (n, d) g, first velocity [m/s]
    known: np.ndarray  # (n, d) mask of the prescribed velocity components
    velocity: np.ndarray  # (n, d) values of the prescribed components [m/s]
    turning: Sequence[ElementRows] | None
    """Measure of rotation, used if some motions have no resistance: among the motions with the same strain rates, the
    solver chooses the one that rotates least. On surfaces this is the motion without mean velocity and rotation."""
    accuracy: float  # allowed relative error of the velocity
    directions: np.ndarray | None = None
    """Directions of the components of vectors and rows at each node, shape (n, d, d); None for the axes of space."""


def refuse_driven(system: System, driven: np.ndarray, most: float) -> None:
    """Raise IncompatibleLoad if loads do work on motions without resistance.

    system: the balance of forces, with the loads; driven: forces of the loads on these motions along the directions of the
    system [N], shape (n, d); most: largest allowed ratio of these forces to the loads, both as sums of magnitudes over the
    nodes.
    """
    if np.linalg.norm(driven, axis=1).sum() > most * np.linalg.norm(system.load, axis=1).sum():
        in_space = driven if system.directions is None else np.einsum("ncd,nc->nd", system.directions, driven)
        raise IncompatibleLoad(in_space)


class FilmSolver(Protocol):
    """Interface of a solver that computes the nodal velocities of a film under linear constraints."""

    def solve(self, system: System, borders: Sequence[Border]) -> Solution:
        """Return the nodal velocities that satisfy the balance of forces and the linear constraints `borders`, and the
        constraint forces. Raises IncompatibleLoad if the loads do work on motions without resistance.
        """

    def state_arrays(self) -> dict[str, np.ndarray]:
        """Return, for a checkpoint, the arrays on which the next solution depends in addition to the system of equations, such
        as the matrix whose factors are the preconditioner.
        """

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        """Restore the arrays that `state_arrays` returned, from a checkpoint."""


UNRESISTED = (
    1e-7  # resistance, relative to the largest, that counts as none: it is 1e-16 for motions without strain, else above 1e-5
)
CURVE_UNBALANCED = 2e-3
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
            load = load - held @ np.linalg.lstsq(held, load, rcond=UNRESISTED)[0]
        driven = np.zeros(self._size)
        driven[free] = unresisted @ load
        refuse_driven(system, driven.reshape(self._shape), CURVE_UNBALANCED)

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
    free = values < UNRESISTED * values[-1]
    return modes[:, ~free], modes[:, free]


def _least_turning(turning: np.ndarray, resisted: np.ndarray, unresisted: np.ndarray) -> np.ndarray:
    """Return a basis, in columns, of the motions that rotate the film least among all motions with the same strain rates.

    turning: matrix of the measure of rotation ∫ |∇v_n|² dA; resisted, unresisted: bases of the motions with and without
    resistance, in columns.
    """
    turns, ways = np.linalg.eigh(unresisted.T @ turning @ unresisted)
    turned = turns > UNRESISTED * np.abs(turning).max()  # translations turn nothing
    ways = unresisted @ ways[:, turned]
    return np.asarray(resisted - ways @ ((ways.T @ turning @ resisted) / turns[turned, None]))


WORTH = 60  # cost of a new factor, in iterations
FEW = 2  # iterations that every solution needs
ROUGH = 8  # iterations with a new factor in single precision from which on double precision is used
MOST = 80  # iterations after which the factor is renewed at once
SHIFT = 1e-3  # resistance added in the factor if motions have none, relative to that of smooth motions
UNBALANCED = 1e-3
"""Largest share of the loads that may act on rigid motions, as an effect of geometric errors. A uniform pressure has no
resultant. On closed surfaces with 26, 42 and 162 nodes, displaced by a third of their spacing in random directions, the
resultant is 4e-4, 1.3e-4 and 2e-5 of ∫|b| dA; it is smaller on ellipsoids with smooth meshes and on surfaces with more
nodes."""
FIXED = 1e-8  # size of a motion at prescribed components below which it counts as free


class SparseSolver:
    """Solves linear systems for the velocities of n nodes, initially at `places` [m], shape (n, 3), assembled from elements
    with nodes (e, m). Components in the mask `held`, shape (n, 3), are 0.
    """

    def __init__(self, nodes: np.ndarray, held: np.ndarray, places: np.ndarray) -> None:
        n, d = held.shape
        self.assembly = Assembly(nodes, n, d)
        self._held = held.ravel()
        self._elimination = Elimination(self.assembly.links(), places, *self.assembly.structure, d)
        self._factor: Factor | None = None
        self._arrays = {
            "factored": np.zeros(0),  # entries of the factored matrix on and above the diagonal
            "sides": np.zeros((0, n * d)),  # Z of the constraints: solutions with their rows as right-hand sides
            "rounds": np.zeros(1, np.int64),  # iterations beyond FEW since the last factorisation
            "double": np.zeros(1, np.int64),  # whether new factors are in double precision
            "in_double": np.zeros(1, np.int64),  # whether the present factor is
            "last": np.zeros((n, d)),  # last velocity
        }

    def state_arrays(self) -> dict[str, np.ndarray]:
        return self._arrays

    def restore(self, arrays: Mapping[str, np.ndarray]) -> None:
        self._arrays = {name: np.array(arrays[name]) for name in self._arrays}
        self._factor = self._made() if len(self._arrays["factored"]) else None

    def solve(self, system: System, borders: Sequence[Border]) -> Solution:
        assembly, arrays = self.assembly, self._arrays
        known = system.known.ravel() | self._held
        free = np.where(known, 0.0, 1.0)
        v = np.where(known, system.velocity.ravel(), 0.0)
        A = assembly.matrix([*system.resistance, *system.stiffness])
        pushed = assembly.gathered([ElementRows(s.rows, s.factor * assembly.rates(s, system.guess)) for s in system.stiffness])
        right = free * (system.force.ravel() + pushed.ravel() - A @ v)
        rows = np.array([border.row.ravel() for border in borders]).reshape(len(borders), len(v))
        goals = np.array([border.rate for border in borders]) - rows @ v
        rigid = _free_motions(system, known) if system.turning is not None else np.zeros((0, len(v)))
        refuse_driven(system, (rigid.T @ (rigid @ system.load.ravel())).reshape(system.load.shape), UNBALANCED)
        factor = self._factor
        new = factor is None or arrays["rounds"][0] > WORTH or len(arrays["sides"]) != len(borders)
        if factor is None or new:
            factor = self.renew(A, system, known, free * rows, len(rigid) > 0)
        C = np.concatenate([free * rows, rigid * np.repeat(system.area, assembly.d)])
        Z = np.concatenate([free * arrays["sides"], rigid])
        start = system.guess if system.guess.any() else arrays["last"]
        u = free * start.ravel()
        projection = Projection(C, Z)
        u += projection.reached(np.concatenate([goals, np.zeros(len(rigid))]) - C @ u)
        u, forces, rounds = self.iterate(factor, A, right, u, free, projection, system.accuracy)
        while rounds == MOST:
            if new and arrays["in_double"][0]:
                raise np.linalg.LinAlgError
            arrays["double"][0] |= new
            factor, new = self.renew(A, system, known, free * rows, len(rigid) > 0), True
            u, forces, rounds = self.iterate(factor, A, right, u, free, projection, system.accuracy)
        arrays["double"][0] |= new and rounds >= ROUGH
        arrays["rounds"][0] += max(rounds - FEW, 0)
        arrays["last"][:] = u.reshape(arrays["last"].shape)
        return Solution((u + v).reshape(system.known.shape), -forces[: len(borders)])

    def iterate(
        self,
        factor: Factor,
        A: csr_array,
        right: np.ndarray,
        u: np.ndarray,
        free: np.ndarray,
        projection: "Projection",
        accuracy: float,
    ) -> tuple[np.ndarray, np.ndarray, int]:
        """Improve the velocities u, shape (3 n,), by conjugate gradients; return the new velocities, the constraint forces,
        shape (k,), and the number of iterations.

        factor: Cholesky factors of the preconditioner; A: matrix; right: right-hand side, shape (3 n,); free: 1 for a free
        component, else 0; projection: projection onto velocities that satisfy the constraints; accuracy: allowed relative
        error.
        """
        u, residual = u.copy(), right - free * (A @ u)
        direction, before = np.zeros_like(u), np.inf
        for rounds in range(MOST):
            held = projection.transposed(residual)
            g = projection.applied(free * factor.solve(held))
            square = float(held @ g)
            if square <= accuracy**2 * abs(float(u @ (right - residual))) or square == 0.0:
                return u, projection.forces(residual), rounds
            direction = g + (square / before) * direction
            pulled = free * (A @ direction)
            step = square / float(direction @ pulled)
            u += step * direction
            residual -= step * pulled
            before = square
        return u, projection.forces(residual), MOST

    def renew(self, A: csr_array, system: System, known: np.ndarray, rows: np.ndarray, shifted: bool) -> Factor:
        """Factor the matrix A without the prescribed components (only their diagonal entries remain); store and return the
        factors.

        system: the balance of forces; known: mask of the prescribed components, shape (3 n,); rows: coefficients of the linear
        constraints, shape (k, 3 n); shifted: True to add a small resistance, proportional to the areas of the nodes, to the
        diagonal.
        """
        diagonal = np.where(known, A.diagonal(), 0.0)
        if shifted:
            squares = [square.of_components(self.assembly.d) for square in system.resistance]
            felt = sum(float(np.einsum("er,erk,erk->", s.factor, s.rows, s.rows)) for s in squares) / len(known)
            diagonal += SHIFT * felt * 4.0 * pi / system.area.sum() * np.repeat(system.area, self.assembly.d)
        self._arrays["factored"] = self.assembly.upper(A, np.where(known, 0.0, 1.0), diagonal)
        self._arrays["in_double"][:] = self._arrays["double"]
        try:
            factor = self._made()
        except np.linalg.LinAlgError:
            if self._arrays["double"][0]:
                raise
            self._arrays["double"][0] = self._arrays["in_double"][0] = 1
            factor = self._made()
        self._factor = factor
        self._arrays["sides"] = np.array([factor.solve(row) for row in rows]).reshape(rows.shape)
        self._arrays["rounds"][0] = 0
        return factor

    def _made(self) -> Factor:
        """Factor the matrix that is stored for checkpoints, in the precision stored with it, and return the factors."""
        precision = np.float64 if self._arrays["in_double"][0] else np.float32
        return Factor(self._elimination, self.assembly.symmetric(self._arrays["factored"]), precision)


class Projection:
    """The matrix P = I - Zᵀ (C Zᵀ)⁻¹ C, which projects onto the vectors u with C u = 0.

    C: coefficients of k linear constraints; Z: k vectors for which C Zᵀ is invertible; shape (k, n) each.
    """

    def __init__(self, C: np.ndarray, Z: np.ndarray) -> None:
        self._C, self._Z = C, Z
        self._inverse = np.linalg.inv(C @ Z.T)

    def reached(self, goals: np.ndarray) -> np.ndarray:
        """Return a vector u, shape (n,), that satisfies the constraints C u = goals."""
        return np.asarray(self._Z.T @ (self._inverse @ goals))

    def applied(self, u: np.ndarray) -> np.ndarray:
        """Return the projection P u of a vector u, shape (n,), onto the vectors that satisfy C u = 0 for the constraints C."""
        return u - self.reached(self._C @ u)

    def forces(self, residual: np.ndarray) -> np.ndarray:
        """Return the constraint forces, shape (k,), that balance a residual of the linear system, shape (n,)."""
        return np.asarray(self._inverse.T @ (self._Z @ residual))

    def transposed(self, residual: np.ndarray) -> np.ndarray:
        """Return the residual of the linear system, shape (n,), without the constraint forces: Pᵀ times the residual."""
        return residual - self._C.T @ self.forces(residual)


def _free_motions(system: System, known: np.ndarray) -> np.ndarray:
    """Return orthonormal rigid motions that leave the prescribed components at rest, shape (k, 3 n).

    system: the balance of forces, with the nodal positions; known: mask of the prescribed components, shape (3 n,).
    """
    x = system.x
    offset = x - x.mean(axis=0)
    motions = [np.tile(axis, (len(x), 1)) for axis in np.eye(3)] + [np.cross(axis, offset) for axis in np.eye(3)]
    if system.directions is not None:
        motions = [np.einsum("ncd,nd->nc", system.directions, motion) for motion in motions]
    basis = np.linalg.qr(np.array(motions).reshape(6, -1).T)[0]
    if not known.any():
        return np.asarray(basis.T)
    _, sizes, turned = np.linalg.svd(basis[known], full_matrices=True)
    small = np.concatenate([sizes, np.zeros(6 - len(sizes))]) < FIXED
    return np.asarray((basis @ turned[small].T).T)
