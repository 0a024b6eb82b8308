"""Factored stiffness of a body with its own nodes, for equilibria: the structure of the matrix, its factors, and solutions with
them. What the entries are is up to the body."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from contextlib import suppress
from typing import Any, NamedTuple

import numpy as np
from scipy import sparse

from pellucid.bodies.own_nodes.twists import loose_twists
from pellucid.contact.frozen import ContactSprings
from pellucid.linear.elimination import Elimination, Factor, Precision, on_one_thread
from pellucid.linear.indefinite import IndefiniteFactor

FIRST_SHIFT, GROWTH, MOST_SHIFT = 1e-5, 10.0, 10.0
"""Stiffness that is added to the diagonal where K is not positive definite, as a fraction of the diagonal: the first, the
factor to the next, and the largest."""
LANCZOS = 16  # vectors
SOFTEST = 1e-6  # error of the smallest eigenvalue plus the shift, relative: a fraction of the shift is compared with 0
UNSTABLE = 1e-9  # smallest eigenvalue over the diagonal, negative, that is no error of the differences
LANCZOS_ERROR = 10.0 * SOFTEST  # of an eigenvalue, over the shift
ROUGH = 1e-2  # error of a smooth displacement up to which factors in single precision are used
CORRECTED, MOST_CORRECTIONS = 1e-10, 200
"""Error of solutions with springs that make the matrix positive definite, in the norm of the energy, and most iterations."""
FREE_SHIFT = 1e-8
"""The same for bodies that can move or rotate as a whole: more than rounding, and much less than any stiffness of the body."""


class Mode(NamedTuple):
    """An eigenvector of the stiffness relative to its diagonal."""

    eigenvalue: float
    displacement: np.ndarray  # (n, 3)
    is_resisted: bool  # True if the eigenvalue is positive, or 0 up to its error


class NodalStiffness(ABC):
    """Stiffness of a body in the state of its last forces, and solutions of linear systems with it.

    links: adjacency matrix of the nodes, shape (n, n); places: positions of the nodes at rest [m], shape (n, 3); pressures:
    number of unknown pressures of each node, which follow its displacements: 0 or 1.
    """

    least_pivot = 0.0
    """Smallest pivot, as a fraction of the diagonal, that is not an error of the matrix; 0 if errors are never so large."""

    def __init__(self, links: sparse.csr_array, places: np.ndarray, pressures: int = 0) -> None:
        self._n, self._d, self._places = len(places), 3 + pressures, places
        d = self._d
        links.sort_indices()
        self._links, counts = (links.indptr.astype(np.int64), links.indices.astype(np.int64)), np.diff(links.indptr)
        row = np.repeat(np.arange(self._n), counts)
        self._indptr = np.concatenate([[0], np.cumsum(np.repeat(d * counts, d))]).astype(np.int64)
        start = self._indptr[d * row]
        place = np.arange(len(row)) - links.indptr[row]
        entry = start[:, None, None] + (d * counts[row])[:, None, None] * np.arange(d)[:, None] + d * place[:, None, None]
        self._entry = entry + np.arange(d)  # (pairs, d, d) entry of the components of each pair of nodes
        self._indices = np.empty(len(row) * d * d, np.int64)
        self._indices[self._entry] = d * links.indices[:, None, None] + np.arange(d)
        self._elimination = Elimination(links, places, self._indptr, self._indices, d, pressures)
        self._diagonal = self._entry[row == links.indices][:, range(d), range(d)]  # (n, d)
        self._values = np.zeros(len(self._indices))
        self._factor: Factor | IndefiniteFactor | None = None
        self._free = np.ones((self._n, d), bool)
        # springs between all nodes by their slopes times the root of their stiffness (Woodbury's formula), and the
        # displacements without springs under these as forces
        self._slopes = self._answers = np.zeros((0, self._n, d))
        self._coupling = np.eye(0)
        self._weights = np.ones((self._n, d))  # of the components in the shift: the largest diagonal entry of each node
        self._excess = 0.0  # stiffness in the factors beyond that of the matrix, as a fraction of the diagonal
        self._motions = 0  # number of motions as a whole that are not prevented
        self.shift = 0.0
        """Stiffness that was added to the diagonal of the last factor, as a fraction of the diagonal: 0 if the body is
        stable."""
        self.unstable_modes = 0
        """Number of negative eigenvalues of the matrix at the last call of `renew_indefinite`."""

    @abstractmethod
    def _find(self, dt: float) -> None:
        """Compute the entries of the matrix in the state of the last forces, in `_values`. dt: time in which displacements come
        about [s], for materials with history variables."""

    def _springs(self) -> list[tuple[float, np.ndarray]]:
        """Return springs between all nodes, which the matrix does not include: the stiffness c of each and the slopes s [m] of
        its length, shape (n, 3). They add c s sᵀ to the matrix."""
        return []

    def links(self) -> sparse.csr_array:
        """Return the adjacency matrix of the nodes, shape (n, n), with the pairs of nodes in the order of its entries."""
        first, linked = self._links
        return sparse.csr_array((np.ones(len(linked)), linked, first), shape=(self._n, self._n))

    def _pairs(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Return the indices of the pairs of nodes (one, other) among all linked pairs."""
        first, linked = self._links
        keys = np.repeat(np.arange(self._n), np.diff(first)) * self._n + linked
        return np.searchsorted(keys, one * self._n + other)

    def renew(
        self,
        free: np.ndarray,
        position: np.ndarray,
        single: bool,
        added: np.ndarray | None = None,
        dt: float = 0.0,
        touching: Sequence[ContactSprings] = (),
    ) -> bool:
        """Compute and factor the matrix in the state of the last forces. Returns False if single precision is not accurate
        enough. If the matrix is not positive definite, stiffness is added to its diagonal, see `shift`.

        free: mask of the components that are not prescribed, shape (n, 3); position: present positions of the nodes [m], shape
        (n, 3); single: True to try single precision first; added: further stiffness of each node against displacements, such as
        that of inertia [N/m], shape (n,); dt: time in which the displacements come about [s], for materials with history
        variables; touching: springs of contact.
        """
        self._find(dt)
        if added is not None:
            self._values[self._diagonal[:, :3]] += added[:, None]
        for contact in touching:
            self._touch(contact)
        self._motions = len(loose_twists(position, free)) if added is None else 0
        self._free[:, :3] = free
        single = self._factored(free, single)
        self._couple_springs()
        self._excess = 0.0
        if self.shift > 0.0 and len(self._slopes) and self._is_held_by_springs():
            self._excess, self.shift = self.shift, 0.0
        return single

    def renew_indefinite(self, free: np.ndarray, position: np.ndarray, added: np.ndarray | None) -> None:
        """Compute and factor the matrix in the state of the last forces as it is, also if it is not positive definite, and
        count its negative eigenvalues in `unstable_modes`. Raises LinAlgError if it is singular.

        free, position: as for `renew`; added: further stiffness between linked nodes, such as that of loads [N/m], shape
        (pairs, 3, 3).
        """
        self._find(0.0)
        if added is not None:
            self._values[self._entry[:, :3, :3]] += added
        self._motions, self._free[:, :3] = len(loose_twists(position, free)), free
        self.shift = self._excess = 0.0
        numbers, diagonal, size = self._without_held(free)
        numbers[diagonal] += (FREE_SHIFT if self._motions else 0.0) * size[free]
        self._factor = IndefiniteFactor(sparse.csr_array((numbers, self._indices, self._indptr)), self._elimination.order)
        if self._has_soft_mode(self._factor, free, size):
            raise np.linalg.LinAlgError
        self._couple_springs()
        pressures = (self._d - 3) * self._n  # of which each has a negative pivot
        by_springs = int(np.count_nonzero(np.linalg.eigvalsh(self._coupling) < 0.0)) if len(self._slopes) else 0
        self.unstable_modes = self._factor.negative - pressures - by_springs

    def _couple_springs(self) -> None:
        """Solve for the displacements under the forces of the springs between all nodes, with the present factors."""
        springs = [np.pad(np.sqrt(stiffness) * slope, ((0, 0), (0, self._d - 3))) for stiffness, slope in self._springs()]
        self._slopes = np.array(springs).reshape(-1, self._n, self._d)
        self._answers = np.array([self._solved_without_springs(slope) for slope in self._slopes]).reshape(self._slopes.shape)
        self._coupling = np.eye(len(springs)) + _products(np.where(self._free, self._slopes, 0.0), self._answers)

    def _touch(self, springs: ContactSprings) -> None:
        """Add springs of contact to the entries of the matrix. Products of nodes that are not linked are added to the diagonal
        instead, which resists no less."""
        shares, normal = springs.shares, springs.normal
        excess = springs.across - springs.along
        turned = sparse.csr_array(shares.T)
        for i in range(3):
            for j in range(3):
                stiffness = excess * normal[:, i] * normal[:, j] + (springs.along if i == j else 0.0)
                entries = sparse.coo_array(turned @ sparse.csr_array(shares * stiffness[:, None]))
                one, other = entries.coords
                at, is_linked = self._find_pairs(one, other)
                self._values[self._entry[at[is_linked]][:, i, j]] += entries.data[is_linked]
                lost = np.abs(entries.data[~is_linked])
                np.add.at(self._values, self._diagonal[one[~is_linked], i], lost)

    def _find_pairs(self, one: np.ndarray, other: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the indices of the pairs of nodes (one, other) among all linked pairs, and a mask of those that are linked."""
        at = np.minimum(self._pairs(one, other), len(self._links[1]) - 1)
        first, linked = self._links
        return at, (linked[at] == other) & (at >= first[one]) & (at < first[one + 1])

    def _factored(self, free: np.ndarray, single: bool) -> bool:
        """Factor the matrix, with stiffness on its diagonal if it is not positive definite. Arguments and result are as for
        `renew`."""
        numbers, diagonal, size = self._without_held(free)
        self.shift = 0.0
        single = single and self._motions == 0  # FREE_SHIFT is below the rounding of single precision
        least, self._weights[:, :3] = FREE_SHIFT if self._motions else 0.0, size
        while True:
            numbers[diagonal] = self._values[diagonal] + (least + self.shift) * size[free]
            precisions: tuple[Precision, ...] = (np.float32, np.float64) if single else (np.float64,)
            for precision in precisions:
                with suppress(np.linalg.LinAlgError):
                    self._factor = Factor(self._elimination, numbers, precision)
                    if self._has_soft_mode(self._factor, free, size):
                        raise np.linalg.LinAlgError
                    if precision is np.float64 or self._is_accurate(self._factor, numbers):
                        return single
                    single = False
            self.shift = max(GROWTH * self.shift, FIRST_SHIFT)
            if not self.shift <= MOST_SHIFT:
                raise np.linalg.LinAlgError

    def _without_held(self, free: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the entries of the matrix in which prescribed components are decoupled, the indices of the diagonal entries of
        the free displacements, and the size of the diagonal, shape (n, 3). free: as for `renew`."""
        flat, d = self._free.ravel(), self._d
        numbers = self._values.copy()
        row = np.repeat(np.arange(d * self._n), np.diff(self._indptr))
        numbers[~(flat[row] & flat[self._indices])] = 0.0
        held, diagonal = self._diagonal[~self._free], self._diagonal[:, :3][free]
        size = np.abs(self._values[self._diagonal[:, :3]])
        size[:] = size.max(axis=1, keepdims=True)  # a flat membrane has no stiffness across its plane
        numbers[held] = size.mean()
        return numbers, diagonal, size

    def _of_motions(self) -> float:
        """Return the largest eigenvalue, relative to the diagonal, of motions of the body as a whole that nothing resists."""
        return 4.0 * FREE_SHIFT if self._motions else 0.0

    def _has_soft_mode(self, factor: Factor | IndefiniteFactor, free: np.ndarray, size: np.ndarray) -> bool:
        """Return True if no more than errors of the matrix, or FREE_SHIFT, resist a displacement that is not a motion of the
        whole body. size: diagonal of the matrix, shape (n, 3)."""
        if self.least_pivot == 0.0:
            return False
        least = self.least_pivot + self._of_motions()
        pivots = factor.pivots().reshape(self._n, self._d)[:, :3]
        return bool(np.count_nonzero(pivots[free] < least * size[free]) > self._motions)

    def _is_accurate(self, factor: Factor, numbers: np.ndarray) -> bool:
        """Return True if factors in single precision reproduce a smooth displacement of the nodes; they do not if the body is
        slender. numbers: entries of the factored matrix."""
        arms = self._places - self._places.mean(axis=0)
        arms /= np.abs(arms).max()
        smooth = np.zeros(self._free.shape)
        smooth[:, :3] = arms * arms + np.roll(arms * arms, 1, axis=1)  # as bent about every axis
        smooth[~self._free] = 0.0
        matrix: Any = sparse.csr_array((numbers, self._indices, self._indptr))
        with on_one_thread():
            found = factor.solve(matrix @ smooth.ravel())
        return bool(np.linalg.norm(found - smooth.ravel()) < ROUGH * np.linalg.norm(smooth))

    def is_factored_for(self, free: np.ndarray) -> bool:
        """Return True if there are factors, and the components that are not prescribed are still those of the mask `free`,
        shape (n, 3)."""
        return self._factor is not None and np.array_equal(self._free[:, :3], free)

    def solve(self, force: np.ndarray) -> np.ndarray:
        """Return the displacements [m], shape (n, 3), under forces on the nodes [N], shape (n, 3); prescribed components have
        none."""
        return self._solved(np.pad(force, ((0, 0), (0, self._d - 3))))[:, :3]

    def follow(self, force: np.ndarray, prescribed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the displacements [m] under forces on the nodes [N] and displacements of prescribed components [m], and the
        forces with which the body resists them [N], shape (n, 3) each."""
        extra = ((0, 0), (0, self._d - 3))
        matrix: Any = sparse.csr_array((self._values, self._indices, self._indptr))
        given = np.pad(prescribed, extra)

        def resisted(moved: np.ndarray) -> np.ndarray:
            return np.asarray((matrix @ moved.ravel()).reshape(given.shape) + self._of_springs(moved))

        found = given + self._solved(np.pad(force, extra) - resisted(given))
        return found[:, :3], resisted(found)[:, :3]

    def resisted_without_springs(self, moved: np.ndarray) -> np.ndarray:
        """Return the forces with which the body without the springs resists displacements [m], shape (n, 3) both."""
        matrix: Any = sparse.csr_array((self._values, self._indices, self._indptr))
        whole = np.pad(moved, ((0, 0), (0, self._d - 3)))
        return np.asarray((matrix @ whole.ravel()).reshape(whole.shape)[:, :3])

    def softest(self) -> "Mode | None":
        """Return the mode with the smallest eigenvalue of the matrix relative to its diagonal; None if the Lanczos method does
        not find it."""
        shift = self.shift + (FREE_SHIFT if self._motions else 0.0)
        found = self._lowest(self._weights[:, :3].ravel(), shift, SOFTEST)
        if found is None:
            return None
        value, vector = float(found[0][0]), found[1][0]
        return Mode(value, vector, value > -max(UNSTABLE, LANCZOS_ERROR * shift, self._of_motions()))

    def _is_held_by_springs(self) -> bool:
        """Return True if the matrix with the springs is positive definite, except for motions of the body as a whole."""
        shift = self.shift + (FREE_SHIFT if self._motions else 0.0)
        found = self._lowest(self._weights[:, :3].ravel(), shift, SOFTEST, self._motions + 1)
        error = max(4.0 * FREE_SHIFT, LANCZOS_ERROR * shift)
        return found is not None and bool(found[0][0] > -error and found[0][-1] > error)

    def _lowest(
        self, weights: np.ndarray, shift: float, tolerance: float, count: int = 1, negative: bool = False
    ) -> tuple[np.ndarray, np.ndarray] | None:
        """Return the smallest eigenvalues of the matrix relative to weights, shape (3 n,), in ascending order, and their
        displacements, shape (count, n, 3), by the Lanczos method with the factors of the matrix and `shift` times the weights;
        None if it does not converge. negative: True if there are `count` negative eigenvalues, and these are sought."""
        from scipy.sparse.linalg import ArpackNoConvergence, LinearOperator, eigsh

        shape = (3 * self._n, 3 * self._n)
        inverse = LinearOperator(shape, lambda force: self.solve(force.reshape(-1, 3)).ravel(), dtype=float)
        diagonal = sparse.diags_array(weights, format="csr")
        start = np.random.default_rng(0).standard_normal(shape[0])
        given: dict[str, Any] = {"M": diagonal, "sigma": -shift, "OPinv": inverse, "v0": start, "tol": tolerance}
        given["which"] = "SA" if negative else "LM"  # of the reciprocal eigenvalues
        with on_one_thread(), suppress(ArpackNoConvergence):
            # the matrix itself is not used
            values, vectors = eigsh(diagonal, count, ncv=min(max(LANCZOS, 4 * count), shape[0]), **given)
            order = np.argsort(values)
            return values[order], vectors.T[order].reshape(count, -1, 3)
        return None

    def lowest_frequency(self, mass: np.ndarray) -> float | None:
        """Return the lowest natural frequency of small vibrations about the present state [Hz]; None if the body is unstable or
        can move as a whole. mass: masses of the nodes [kg], shape (n,)."""
        if self.shift > 0.0 or self._motions > 0 or not self._free[:, :3].any():
            return None
        found = self._lowest(np.repeat(mass, 3), 0.0, 1e-3)
        return None if found is None else float(np.sqrt(found[0][0])) / (2.0 * np.pi)

    def signed_frequency(self, mass: np.ndarray) -> float | None:
        """Return the lowest natural frequency [Hz] with the factors of `renew_indefinite`, negative if it is imaginary: -f for
        a disturbance that grows as exp(2π f t). None if it is not known; mass: as for `lowest_frequency`."""
        if self._motions > 0 or not self._free[:, :3].any():
            return None
        unstable = self.unstable_modes
        found = self._lowest(np.repeat(mass, 3), 0.0, 1e-3, max(unstable, 1), unstable > 0)
        if found is None:
            return None
        square = float(found[0][0])
        return float(np.copysign(np.sqrt(abs(square)), square)) / (2.0 * np.pi)

    def _solved(self, right: np.ndarray) -> np.ndarray:
        if self._excess == 0.0:
            return self._solved_nearly(right)
        return conjugate_gradients(self._resisted_freely, self._solved_nearly, np.where(self._free, right, 0.0))

    def _resisted_freely(self, moved: np.ndarray) -> np.ndarray:
        """Return the forces with which the body with its springs resists displacements of the free components."""
        matrix: Any = sparse.csr_array((self._values, self._indices, self._indptr))
        force = (matrix @ moved.ravel()).reshape(moved.shape) + self._of_springs(moved)
        if self._motions:
            force[:, :3] += FREE_SHIFT * self._weights[:, :3] * moved[:, :3]
        return np.where(self._free, force, 0.0)

    def _of_springs(self, moved: np.ndarray) -> np.ndarray:
        pulled = _products(self._slopes, moved[None])[:, 0]
        return np.asarray(np.einsum("k,kij->ij", pulled, self._slopes))

    def _solved_nearly(self, right: np.ndarray) -> np.ndarray:
        """Return the solution with the factors and springs, without the correction of the excess."""
        found = self._solved_without_springs(right)
        if not len(self._slopes):
            return found
        pulled = np.linalg.solve(self._coupling, _products(self._slopes, found[None])[:, 0])
        return np.asarray(found - np.einsum("k,kij->ij", pulled, self._answers))

    def _solved_without_springs(self, right: np.ndarray) -> np.ndarray:
        if self._factor is None:
            raise ValueError("the stiffness was not factored")
        with on_one_thread():
            found = self._factor.solve(np.where(self._free, right, 0.0).ravel())
        return np.asarray(found.reshape(self._n, self._d))


def conjugate_gradients(
    product: Callable[[np.ndarray], np.ndarray],
    solved_nearly: Callable[[np.ndarray], np.ndarray],
    right: np.ndarray,
    accuracy: float = CORRECTED,
) -> np.ndarray:
    """Return the solution x of A x = right for a positive definite matrix A by the preconditioned method of conjugate gradients
    (Nocedal & Wright 2006, algorithm 5.3).

    product: function that returns A x; solved_nearly: function that returns the solution with an approximation of A; accuracy:
    error of the solution, in the norm of the energy. If A is not positive definite along a direction, the last approximation is
    returned.
    """
    found, residual = np.zeros_like(right), right.copy()
    near = solved_nearly(residual)
    direction, size = near, float(np.sum(residual * near))
    first = size
    for _ in range(MOST_CORRECTIONS):
        if size <= accuracy**2 * first:
            break
        force = product(direction)
        curvature = float(np.sum(direction * force))
        if curvature <= 0.0:
            break
        found, residual = found + size / curvature * direction, residual - size / curvature * force
        near = solved_nearly(residual)
        before, size = size, float(np.sum(residual * near))
        direction = near + size / before * direction
    return found if found.any() else near


def _products(some: np.ndarray, others: np.ndarray) -> np.ndarray:
    """Return the sums of the products of the entries of arrays, shapes (k, n, d) and (l, n, d), shape (k, l)."""
    return np.array([[float(np.sum(one * other)) for other in others] for one in some]).reshape(len(some), len(others))
