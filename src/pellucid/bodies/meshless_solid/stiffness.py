"""Stiffness of a meshless solid for equilibria, from differences of the stress at its points, and its factorisation.

f_a = -Σ_q w P(F_q) ∇p_a, so that K = -∂f/∂u = Σ_q w Gᵀ (∂P/∂F) G. The 81 derivatives ∂P/∂F of a point are central
differences of the stresses that the material computes in every step: no law has to define them. If the volume ratio is
averaged around the nodes, K has the further part Bᵀ D B, with the derivatives B of the volumes around the nodes and D =
U''(J̄_a)/V_a. This part links nodes far apart. It is replaced by one unknown p = D B u per node, the change of the mean
pressure around it: [K Bᵀ; B -D⁻¹] is quasi-definite and has fewer entries.
"""

from contextlib import suppress
from typing import Any

import numpy as np
from scipy import sparse

from pellucid.bodies.meshless_solid.forces import (
    fill_batch,
    find_stresses,
    in_kernels,
    mean_stresses,
)
from pellucid.bodies.meshless_solid.solid import BATCH, COLUMN, COLUMNS, PACKS, STRESS, Solid, displacements, nodes_of_entries
from pellucid.bodies.meshless_solid.stable_step import VolumeRates, stiffness_of_volume
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.calls import call_kernel
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES
from pellucid.linear.elimination import Elimination, Factor, Precision, on_one_thread
from pellucid.materials.law import volumetric_stress

STEP = 1e-5  # change of a component of F for the differences: their error is 1e-10, that of rounding 1e-11
CHUNK = 2048  # nodes
LEAST_BULK = 1e-3  # smallest U'' of the factors, as a fraction of that at rest: laws may soften in large changes of volume
FIRST_SHIFT, GROWTH, MOST_SHIFT = 1e-5, 10.0, 10.0
"""Stiffness that is added to the diagonal where K is not positive definite, as a fraction of the diagonal: the first, the
factor to the next, and the largest."""
ROUGH = 1e-2  # error of a smooth displacement up to which factors in single precision are used
FREE_SHIFT = 1e-8
"""The same for bodies that can move or rotate as a whole: more than rounding, and much less than any stiffness of the body."""


@parallel_loop(allocates=True)
def _find_moduli(block, solid, step, dt, moduli):
    """Compute the derivatives of the first Piola-Kirchhoff stress with respect to the deformation gradient at the points of a
    block (a group of packs), times the quadrature weights, in `moduli`, shape (points, 81): entry 9 r + c is the derivative of
    component r with respect to component c.

    solid: a `SolidInKernels` in the state of its last forces; step: difference of a component of the deformation gradient; dt:
    time in which it comes about [s].
    """
    mesh = solid.mesh
    blocks, averaged = mesh.blocks, len(mesh.block_volume) > 0
    start, m = blocks.first[block], blocks.first[block + 1] - blocks.first[block]
    u = displacements(start, m, mesh)
    mean, s, above = mean_stresses(start, m, mesh), np.zeros(COLUMNS * COLUMN), np.zeros(9 * COLUMN)
    for first in range(PACKS * block, min(PACKS * (block + 1), len(mesh.corners.first) - 1), BATCH):
        n = min(BATCH, len(mesh.corners.first) - 1 - first)
        call_kernel(fill_batch, first, n, mesh, averaged, mean, u, s)
        for c in range(9):
            for i in range(COLUMN):
                s[c * COLUMN + i] += step
            find_stresses(solid.points, first, n, solid, dt, False, averaged, s)
            above[:] = s[STRESS * COLUMN : (STRESS + 9) * COLUMN]
            for i in range(COLUMN):
                s[c * COLUMN + i] -= 2.0 * step
            find_stresses(solid.points, first, n, solid, dt, False, averaged, s)
            for i in range(COLUMN):
                s[c * COLUMN + i] += step
            for r in range(9):
                for i in range(n * LANES):
                    change = above[r * COLUMN + i] - s[(STRESS + r) * COLUMN + i]
                    moduli[LANES * first + i, 9 * r + c] = change / (2.0 * step)


@parallel_loop()
def _find_bulk(chunk, law, ratio, step, bulk):
    """Compute U'' at the averaged volume ratios `ratio` of a chunk of nodes [Pa], by central differences of `step`."""
    for a in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(ratio))):
        change = volumetric_stress(law, ratio[a] + step) - volumetric_stress(law, ratio[a] - step)
        bulk[a] = change / (2.0 * step)


@kernel(inner=True)
def _gradients_of_pack(pack, solid, g):
    """Write the gradients ∇p_a = Kᵀ g_a at the LANES points of a pack to g, shape (nodes, 3 LANES)."""
    first, numbers, turns = solid.gradients.first, solid.gradients.numbers, solid.turns
    for e in range(first[pack + 1] - first[pack]):
        k = 3 * LANES * (first[pack] + e)
        for lane in range(LANES):
            x, y, z = numbers[k + lane], numbers[k + LANES + lane], numbers[k + 2 * LANES + lane]
            t = 9 * LANES * pack + lane
            g[e, 3 * lane] = x + x * turns[t] + y * turns[t + 3 * LANES] + z * turns[t + 6 * LANES]
            g[e, 3 * lane + 1] = y + x * turns[t + LANES] + y * turns[t + 4 * LANES] + z * turns[t + 7 * LANES]
            g[e, 3 * lane + 2] = z + x * turns[t + 2 * LANES] + y * turns[t + 5 * LANES] + z * turns[t + 8 * LANES]


@kernel(allocates=True)
def _assemble(solid, nodes, moduli, d, indptr, indices, values):
    """Add K to `values`, the entries of a sparse matrix with d unknowns per node (the first three are displacements), row by
    row.

    solid: data of `Solid`; nodes: nodes of the packs, entry by entry, ascending in each pack; moduli: shape (points, 81);
    indptr, indices: linked nodes of each node, ascending.
    """
    first = solid.gradients.first
    longest = 0
    for pack in range(len(first) - 1):
        longest = max(longest, first[pack + 1] - first[pack])
    all_g, all_w = np.empty((longest, 3 * LANES)), np.empty(3 * LANES * 9 * longest)
    for pack in range(len(first) - 1):
        m = first[pack + 1] - first[pack]
        g, w = all_g[:m], all_w[: 27 * LANES * m].reshape(3 * LANES, 9 * m)
        _gradients_of_pack(pack, solid, g)
        for lane in range(LANES):
            q = LANES * pack + lane
            for i in range(3):
                for k in range(3):
                    at = (3 * i + k) * m
                    for J in range(3):
                        c = 9 * (3 * i + J) + 3 * k
                        x, y, z = moduli[q, c], moduli[q, c + 1], moduli[q, c + 2]
                        for b in range(m):
                            w[3 * lane + J, at + b] = x * g[b, 3 * lane] + y * g[b, 3 * lane + 1] + z * g[b, 3 * lane + 2]
        local = np.dot(g, w)
        for a in range(m):
            row = nodes[first[pack] + a]
            begin, linked = indptr[row], indptr[row + 1] - indptr[row]
            place = 0
            for b in range(m):
                node = nodes[first[pack] + b]
                while indices[begin + place] != node:
                    place += 1
                for i in range(3):
                    at = d * d * begin + d * linked * i + d * place
                    for k in range(3):
                        values[at + k] += local[a, (3 * i + k) * m + b]


class SolidStiffness:
    """Stiffness of a meshless solid in the state of its last forces, and solutions of linear systems with it.

    solid: data of the solid, as in its forces; places: positions of the nodes at rest [m], shape (n, 3).
    """

    def __init__(self, solid: Solid, places: np.ndarray) -> None:
        self._solid, self._in_kernels, self._n = solid, in_kernels(solid), len(places)
        self._averaged = len(solid.block_volume) > 0
        self._d = d = 4 if self._averaged else 3
        self._nodes = nodes_of_entries(solid.gradients, solid.blocks)
        pack = np.repeat(np.arange(len(solid.gradients.first) - 1), np.diff(solid.gradients.first))
        touch = sparse.csr_array((np.ones(len(pack), np.int32), (self._nodes, pack)))
        links = sparse.csr_array(touch @ touch.T)
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
        self._elimination = Elimination(links, places, self._indptr, self._indices, d, d - 3)
        self._diagonal = self._entry[row == links.indices][:, range(d), range(d)]  # (n, d)
        self._rates = VolumeRates(solid) if self._averaged else None
        self._values = np.zeros(len(self._indices))
        self._places = places
        self._factor: Factor | None = None
        self._free = np.ones((self._n, d), bool)
        self.shift = 0.0
        """Stiffness that was added to the diagonal of the last factor, as a fraction of the diagonal: 0 if the solid is
        stable."""

    def _find(self, dt: float) -> None:
        """Compute the entries of the matrix in the state of the last forces."""
        solid, moduli = self._solid, np.empty((len(self._solid.weights), 81))
        _find_moduli(len(solid.sums), self._in_kernels, STEP, dt, moduli)
        self._values.fill(0.0)
        with on_one_thread():
            _assemble(Bundle(solid._replace(law=(), points=())), self._nodes, moduli, self._d, *self._links, self._values)
        if self._rates is not None:
            self._add_volumes(self._rates)

    def _add_volumes(self, rates: VolumeRates) -> None:
        """Add the unknown pressures, in units in which they are as large as the displacements."""
        solid, n = self._solid, self._n
        bulk = np.empty(n)
        _find_bulk(-(-n // CHUNK), solid.law, solid.volume_ratio, STEP, bulk)
        compliance = solid.volume / np.maximum(bulk, LEAST_BULK * stiffness_of_volume(solid))
        unit = float(np.sqrt(np.abs(self._values[self._diagonal[:, :3]]).mean() / compliance.mean()))
        found = sparse.csr_array(rates.find())
        of_node = np.repeat(np.arange(n), np.diff(found.indptr) // 3)
        other, numbers = found.indices[::3] // 3, unit * found.data.reshape(-1, 3)
        there, back = self._pairs(of_node, other), self._pairs(other, of_node)
        self._values[self._entry[there][:, 3, :3]] = numbers
        self._values[self._entry[back][:, :3, 3]] = numbers
        self._values[self._diagonal[:, 3]] = -unit * unit * compliance

    def _pairs(self, one: np.ndarray, other: np.ndarray) -> np.ndarray:
        """Return the indices of the pairs of nodes (one, other) among all linked pairs."""
        first, linked = self._links
        keys = np.repeat(np.arange(self._n), np.diff(first)) * self._n + linked
        return np.searchsorted(keys, one * self._n + other)

    def renew(self, free: np.ndarray, moves: bool, single: bool, added: np.ndarray | None = None, dt: float = 0.0) -> bool:
        """Compute and factor the matrix in the state of the last forces. Returns False if single precision is not accurate
        enough. If the matrix is not positive definite, stiffness is added to its diagonal, see `shift`.

        free: mask of the components that are not prescribed, shape (n, 3); moves: True if the solid can move or rotate as a
        whole; single: True to try single precision first; added: further stiffness of each node against displacements [N/m],
        shape (n,); dt: time in which the displacements come about [s], for materials with history variables.
        """
        self._find(dt)
        if added is not None:
            self._values[self._diagonal[:, :3]] += added[:, None]
        self._free[:, :3] = free
        flat, d = self._free.ravel(), self._d
        numbers = self._values.copy()
        row = np.repeat(np.arange(d * self._n), np.diff(self._indptr))
        numbers[~(flat[row] & flat[self._indices])] = 0.0
        held, diagonal = self._diagonal[~self._free], self._diagonal[:, :3][free]
        size = np.abs(self._values[self._diagonal[:, :3]])
        numbers[held] = size.mean()
        self.shift = 0.0
        single = single and not moves  # FREE_SHIFT is below the rounding of single precision
        while True:
            numbers[diagonal] = self._values[diagonal] + (FREE_SHIFT * moves + self.shift) * size[free]
            precisions: tuple[Precision, ...] = (np.float32, np.float64) if single else (np.float64,)
            for precision in precisions:
                with suppress(np.linalg.LinAlgError):
                    self._factor = Factor(self._elimination, numbers, precision)
                    if precision is np.float64 or self._is_accurate(self._factor, numbers):
                        return single
                    single = False
            self.shift = max(GROWTH * self.shift, FIRST_SHIFT)
            if not self.shift <= MOST_SHIFT:
                raise np.linalg.LinAlgError

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

    def solve(self, force: np.ndarray) -> np.ndarray:
        """Return the displacements [m], shape (n, 3), under forces on the nodes [N], shape (n, 3); prescribed components have
        none."""
        return self._solved(np.pad(force, ((0, 0), (0, self._d - 3))))[:, :3]

    def follow(self, force: np.ndarray, prescribed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the displacements [m] under forces on the nodes [N] and displacements of prescribed components [m], and the
        forces with which the solid resists them [N], shape (n, 3) each."""
        extra = ((0, 0), (0, self._d - 3))
        matrix: Any = sparse.csr_array((self._values, self._indices, self._indptr))
        given = np.pad(prescribed, extra)
        found = given + self._solved(np.pad(force, extra) - (matrix @ given.ravel()).reshape(given.shape))
        return found[:, :3], (matrix @ found.ravel()).reshape(given.shape)[:, :3]

    def _solved(self, right: np.ndarray) -> np.ndarray:
        if self._factor is None:
            raise ValueError("the stiffness was not factored")
        with on_one_thread():
            found = self._factor.solve(np.where(self._free, right, 0.0).ravel())
        return np.asarray(found.reshape(self._n, self._d))


def is_held(places: np.ndarray, free: np.ndarray) -> bool:
    """Return True if the prescribed components prevent every motion of a body as a whole.

    places: positions of the nodes [m], shape (n, 3); free: mask of the components that are not prescribed, shape (n, 3).
    """
    arms = places - places.mean(axis=0)
    arms = arms / (np.abs(arms).max() or 1.0)
    motions = np.zeros((6, *free.shape))
    for axis in range(3):
        motions[axis, :, axis] = 1.0
        motions[3 + axis] = np.cross(np.eye(3)[axis], arms)
    resisted = (motions * ~free).reshape(6, -1)
    return bool(np.linalg.matrix_rank(resisted @ resisted.T, tol=1e-9 * len(places)) == 6)
