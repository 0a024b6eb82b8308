"""Internal forces of a meshless solid in total-Lagrangian form.

F = I + Σ u_a ⊗ ∇p_a and f_a = -Σ_q w_q P(F_q) ∇p_a(q) over quadrature points of the cells, with gradients by the reference
configuration, found once (Horton et al. 2010, Int. J. Numer. Methods Biomed. Eng. 26, 977; Mountris et al. 2019, section 4).

Nearly incompressible solids would lock: their volume ratio is averaged about the corners a of the cells, with the linear
functions N_a, J̄_a = Σ_q w N_a J / V_a, V_a = Σ_q w N_a, and the volumetric part U(J) of the energy is taken of J̄_a, V_a
each: P = ∂W/∂F + (Σ_a N_a U'(J̄_a) - U'(J)) cof F. (The average nodal pressure of Bonet & Burton 1998, Commun. Numer. Methods
Eng. 14, 437, for linear tetrahedra.)

Cells are shared out in blocks that do not depend on the threads. A block sums what it gives to its own nodes; each node then
adds up what its blocks have, in their order.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for
from pellucid.jit.vector import LANES, load, splat, store, total
from pellucid.materials.law import energy, first_piola_kirchhoff, volumetric_energy, volumetric_stress
from pellucid.tensors import cofactor, determinant

CELLS = 1024  # of a block
CHUNK = 2048  # nodes
ENERGY, LEAST_J = range(2)  # columns of the sums of a block


class Blocks(NamedTuple):
    """The nodes of each block of cells, and the places of each node in the blocks."""

    first: np.ndarray  # (blocks + 1,)
    nodes: np.ndarray  # those of block b from first[b] to first[b + 1]
    local: np.ndarray  # for each entry of the cells' lists, the number of its node within the block
    node_first: np.ndarray  # (n + 1,)
    places: np.ndarray  # of node a in `nodes`, from node_first[a] to node_first[a + 1], ascending


class Solid(NamedTuple):
    """What kernels take of a solid."""

    law: Any
    shares: np.ndarray  # (points, 4) of the corners at the points of a cell
    first: np.ndarray  # of each cell's active nodes
    gradients: np.ndarray  # [cell][point][direction][node] [1/m]
    weights: np.ndarray  # (c,) volume of each point of a cell [m³]
    blocks: Blocks
    corners: np.ndarray  # (c, 4) of the cells, by their number within the block
    displacement: np.ndarray  # (n, 3) [m]
    deformation: np.ndarray  # (c, points, 9) deformation gradients
    block_force: np.ndarray  # (places, 3) [N]
    block_volume: np.ndarray  # (places,) Σ w N_a J of each block, no rows where J is not averaged
    volume: np.ndarray  # (n,) V_a [m³]
    volume_ratio: np.ndarray  # (n,) J̄_a
    mean_stress: np.ndarray  # (n,) U'(J̄_a) [Pa]
    sums: np.ndarray  # (blocks, 2)
    node_sums: np.ndarray  # (chunks, 2)


@kernel(inner=True)
def _deformation_gradient(n, G, at, u):
    """F from the gradients of n nodes of a cell, which begin at `at` of G, and their displacements u, by components of n."""
    zero = splat(0.0)
    a, b, c, d, e, f, g, h, i = zero, zero, zero, zero, zero, zero, zero, zero, zero
    for k in range(0, n, LANES):
        x, y, z = load(G, at + k), load(G, at + n + k), load(G, at + 2 * n + k)
        ux, uy, uz = load(u, k), load(u, n + k), load(u, 2 * n + k)
        a, b, c = a + ux * x, b + ux * y, c + ux * z
        d, e, f = d + uy * x, e + uy * y, f + uy * z
        g, h, i = g + uz * x, h + uz * y, i + uz * z
    first = (1.0 + total(a), total(b), total(c), total(d), 1.0 + total(e))
    return (first[0], first[1], first[2], first[3], first[4], total(f), total(g), total(h), 1.0 + total(i))


@kernel(inner=True)
def _add_forces(n, P, G, at, f):
    """Take P ∇p_a from the forces f of the nodes of a cell, by components of n."""
    for k in range(0, n, LANES):
        x, y, z = load(G, at + k), load(G, at + n + k), load(G, at + 2 * n + k)
        store(f, k, load(f, k) - (P[0] * x + P[1] * y + P[2] * z))
        store(f, n + k, load(f, n + k) - (P[3] * x + P[4] * y + P[5] * z))
        store(f, 2 * n + k, load(f, 2 * n + k) - (P[6] * x + P[7] * y + P[8] * z))


@kernel(inner=True)
def _deform_block(block, solid):
    blocks, G, nq, averaged = solid.blocks, solid.gradients, len(solid.shares), len(solid.block_volume) > 0
    start, end = blocks.first[block], blocks.first[block + 1]
    m = end - start
    u = np.empty(3 * m)
    for k in range(m):
        for d in range(3):
            u[d * m + k] = solid.displacement[blocks.nodes[start + k], d]
    if averaged:
        volume = solid.block_volume[start:end]
        volume[:] = 0.0
    local = np.empty(3 * m + 3 * LANES)
    least = np.inf
    for cell in range(CELLS * block, min(CELLS * (block + 1), len(solid.weights))):
        here, w = solid.first[cell], solid.weights[cell]
        n = solid.first[cell + 1] - here
        for k in range(n):
            place = blocks.local[here + k]
            for d in range(3):
                local[d * n + k] = u[d * m + place]
        for q in range(nq):
            at = 3 * (nq * here + q * n)
            F = _deformation_gradient(n, G, at, local)
            J = determinant(F)
            least = min(least, J)
            for k in range(9):
                solid.deformation[cell, q, k] = F[k]
            if averaged:
                for corner in range(4):
                    volume[solid.corners[cell, corner]] += w * J * solid.shares[q, corner]
    solid.sums[block, LEAST_J] = least


@kernel(inner=True)
def _average_chunk(chunk, solid):
    blocks, least, total = solid.blocks, np.inf, 0.0
    for a in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(solid.volume))):
        volume = 0.0
        for place in range(blocks.node_first[a], blocks.node_first[a + 1]):
            volume += solid.block_volume[blocks.places[place]]
        J = solid.volume_ratio[a] = volume / solid.volume[a]
        least = min(least, J)
        total += solid.volume[a] * volumetric_energy(solid.law, J)
        solid.mean_stress[a] = volumetric_stress(solid.law, J)
    solid.node_sums[chunk, ENERGY], solid.node_sums[chunk, LEAST_J] = total, least


@kernel(inner=True)
def _force_block(block, solid):
    blocks, G, nq, averaged = solid.blocks, solid.gradients, len(solid.shares), len(solid.block_volume) > 0
    start, end = blocks.first[block], blocks.first[block + 1]
    m = end - start
    f, local = np.zeros(3 * m), np.empty(3 * m + 3 * LANES)
    stored = 0.0
    for cell in range(CELLS * block, min(CELLS * (block + 1), len(solid.weights))):
        here, w = solid.first[cell], solid.weights[cell]
        n = solid.first[cell + 1] - here
        local[: 3 * n] = 0.0
        for q in range(nq):
            F = solid.deformation[cell, q]
            F = (F[0], F[1], F[2], F[3], F[4], F[5], F[6], F[7], F[8])
            P = first_piola_kirchhoff(solid.law, F)
            stored += w * energy(solid.law, F)
            extra = 0.0
            if averaged:
                J = determinant(F)
                stored -= w * volumetric_energy(solid.law, J)
                extra -= volumetric_stress(solid.law, J)
                for corner in range(4):
                    extra += solid.shares[q, corner] * solid.mean_stress[blocks.nodes[start + solid.corners[cell, corner]]]
            C = cofactor(F)
            P = (
                w * (P[0] + extra * C[0]),
                w * (P[1] + extra * C[1]),
                w * (P[2] + extra * C[2]),
                w * (P[3] + extra * C[3]),
                w * (P[4] + extra * C[4]),
                w * (P[5] + extra * C[5]),
                w * (P[6] + extra * C[6]),
                w * (P[7] + extra * C[7]),
                w * (P[8] + extra * C[8]),
            )
            at = 3 * (nq * here + q * n)
            _add_forces(n, P, G, at, local)
        for k in range(n):
            place = blocks.local[here + k]
            for d in range(3):
                f[d * m + place] += local[d * n + k]
    for k in range(m):
        for d in range(3):
            solid.block_force[start + k, d] = f[d * m + k]
    solid.sums[block, ENERGY] = stored


@kernel(inner=True)
def _add_blocks(chunk, solid, force):
    blocks = solid.blocks
    for a in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(force))):
        for d in range(3):
            force[a, d] = 0.0
        for place in range(blocks.node_first[a], blocks.node_first[a + 1]):
            for d in range(3):
                force[a, d] += solid.block_force[blocks.places[place], d]


@kernel()
def internal_forces(n_blocks, chunks, solid, force):
    """Fill force (n, 3) [N], the deformation gradients, and the sums of blocks and chunks."""
    parallel_for(_deform_block, n_blocks, solid)
    if len(solid.block_volume) > 0:
        parallel_for(_average_chunk, chunks, solid)
    parallel_for(_force_block, n_blocks, solid)
    parallel_for(_add_blocks, chunks, solid, force)
