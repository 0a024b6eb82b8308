"""Stiffness of a meshless solid for equilibria, from differences of the stress at its points, and its factorisation.

f_a = -Σ_q w P(F_q) ∇p_a, so that K = -∂f/∂u = Σ_q w Gᵀ (∂P/∂F) G. The 81 derivatives ∂P/∂F of a point are central
differences of the stresses that the material computes in every step: no law has to define them. If the volume ratio is
averaged around the nodes, K has the further part Bᵀ D B, with the derivatives B of the volumes around the nodes and D =
U''(J̄_a)/V_a. This part links nodes far apart. It is replaced by one unknown p = D B u per node, the change of the mean
pressure around it: [K Bᵀ; B -D⁻¹] is quasi-definite and has fewer entries.
"""

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
from pellucid.bodies.own_nodes.stiffness import NodalStiffness
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.calls import call_kernel
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES
from pellucid.linear.elimination import on_one_thread
from pellucid.materials.law import volumetric_stress

STEP = 1e-5  # change of a component of F for the differences: their error is 1e-10, that of rounding 1e-11
CHUNK = 2048  # nodes
LEAST_BULK = 1e-3  # smallest U'' of the factors, as a fraction of that at rest: laws may soften in large changes of volume


@parallel_loop(allocates=True)
def _find_moduli(block, solid, step, dt, n, moduli):
    """Add the derivatives of the first Piola-Kirchhoff stress with respect to the deformation gradient at the points of a block
    (a group of packs), times the quadrature weights, to `moduli`, with one row for n consecutive points, shape (rows, 81):
    entry 9 r + c is the derivative of component r with respect to component c.

    solid: a `SolidInKernels` in the state of its last forces; step: difference of a component of the deformation gradient; dt:
    time in which it comes about [s]; n: 1, or the number of points of a cell, of which a block has all.
    """
    mesh = solid.mesh
    blocks, averaged = mesh.blocks, len(mesh.block_volume) > 0
    start, m = blocks.first[block], blocks.first[block + 1] - blocks.first[block]
    u = displacements(start, m, mesh)
    mean, s, above = mean_stresses(start, m, mesh), np.zeros(COLUMNS * COLUMN), np.zeros(9 * COLUMN)
    for first in range(PACKS * block, min(PACKS * (block + 1), len(mesh.corners.first) - 1), BATCH):
        packs = min(BATCH, len(mesh.corners.first) - 1 - first)
        call_kernel(fill_batch, first, packs, mesh, averaged, mean, u, s)
        for c in range(9):
            for i in range(COLUMN):
                s[c * COLUMN + i] += step
            find_stresses(solid.points, first, packs, solid, dt, False, averaged, s)
            above[:] = s[STRESS * COLUMN : (STRESS + 9) * COLUMN]
            for i in range(COLUMN):
                s[c * COLUMN + i] -= 2.0 * step
            find_stresses(solid.points, first, packs, solid, dt, False, averaged, s)
            for i in range(COLUMN):
                s[c * COLUMN + i] += step
            for r in range(9):
                for i in range(packs * LANES):
                    change = above[r * COLUMN + i] - s[(STRESS + r) * COLUMN + i]
                    moduli[(LANES * first + i) // n, 9 * r + c] += change / (2.0 * step)


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


class AveragedStiffness(NodalStiffness):
    """Stiffness of a meshless solid that may have an unknown pressure per node; arguments as for `NodalStiffness`, and the data
    of the solid, as in its forces."""

    def __init__(self, solid: Solid, links: sparse.csr_array, places: np.ndarray) -> None:
        self._solid, self._in_kernels = solid, in_kernels(solid)
        self._averages = len(solid.block_volume) > 0
        super().__init__(links, places, 1 if self._averages else 0)

    def _moduli(self, dt: float, n: int) -> np.ndarray:
        """Return the moduli of each n consecutive points in the state of the last forces, times the weights, see
        `_find_moduli`. dt: time in which displacements come about [s]."""
        moduli = np.zeros((-(-len(self._solid.weights) // n), 81))
        _find_moduli(len(self._solid.sums), self._in_kernels, STEP, dt, n, moduli)
        return moduli

    def _add_pressures(self) -> float:
        """Add the compliance of the unknown pressures to the matrix, whose other entries must be there. Returns the unit in
        which the pressures are as large as the displacements, by which B is multiplied."""
        solid, n = self._solid, self._n
        bulk = np.empty(n)
        _find_bulk(-(-n // CHUNK), solid.law, solid.volume_ratio, STEP, bulk)
        compliance = solid.volume / np.maximum(bulk, LEAST_BULK * stiffness_of_volume(solid))
        unit = float(np.sqrt(np.abs(self._values[self._diagonal[:, :3]]).mean() / compliance.mean()))
        self._values[self._diagonal[:, 3]] = -unit * unit * compliance
        return unit


class SolidStiffness(AveragedStiffness):
    """Stiffness of a meshless solid in the state of its last forces, and solutions of linear systems with it.

    solid: data of the solid, as in its forces; places: positions of the nodes at rest [m], shape (n, 3).
    """

    def __init__(self, solid: Solid, places: np.ndarray) -> None:
        self._nodes = nodes_of_entries(solid.gradients, solid.blocks)
        pack = np.repeat(np.arange(len(solid.gradients.first) - 1), np.diff(solid.gradients.first))
        touch = sparse.csr_array((np.ones(len(pack), np.int32), (self._nodes, pack)))
        super().__init__(solid, sparse.csr_array(touch @ touch.T), places)
        self._rates = VolumeRates(solid) if self._averages else None

    def _find(self, dt: float) -> None:
        solid, moduli = self._solid, self._moduli(dt, 1)
        self._values.fill(0.0)
        with on_one_thread():
            _assemble(Bundle(solid._replace(law=(), points=())), self._nodes, moduli, self._d, *self._links, self._values)
        if self._rates is not None:
            self._add_volumes(self._rates)

    def _add_volumes(self, rates: VolumeRates) -> None:
        """Add the unknown pressures."""
        unit = self._add_pressures()
        found = sparse.csr_array(rates.find())
        of_node = np.repeat(np.arange(self._n), np.diff(found.indptr) // 3)
        other, numbers = found.indices[::3] // 3, unit * found.data.reshape(-1, 3)
        there, back = self._pairs(of_node, other), self._pairs(other, of_node)
        self._values[self._entry[there][:, 3, :3]] = numbers
        self._values[self._entry[back][:, :3, 3]] = numbers
