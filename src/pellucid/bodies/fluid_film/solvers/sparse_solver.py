"""Solver for the nodal velocities of a film with many nodes, such as a surface: conjugate gradients with earlier Cholesky
factors as preconditioner.

The matrix changes little from step to step, so its factors serve for many steps; they are recomputed when the saved iterations
exceed the cost. They are in single precision, with half the time and memory, until a new factor needs as many iterations as an
old one. Constraints C v = c hold in every iteration: directions and residuals are projected by P = I - Z (C Z)⁻¹ C and its
transpose, with any vectors Z for which C Z is invertible (Gould, Hribar & Nocedal 2001, SIAM J. Sci. Comput. 23, 1376). Motions
R without resistance are removed in the same way, with Z = R and C = Rᵀ times the areas of the nodes; on a closed surface these
are the rigid motions.
"""

from collections.abc import Mapping, Sequence
from math import pi

import numpy as np
from scipy.sparse import csr_array

from pellucid.bodies.fluid_film.forms.nodal_sums import ElementRows
from pellucid.bodies.fluid_film.solvers.assembly import Assembly
from pellucid.bodies.fluid_film.solvers.contract import Border, Solution, System, refuse_driven
from pellucid.bodies.fluid_film.solvers.elimination import Elimination, Factor

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
