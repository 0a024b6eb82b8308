"""Internal forces of a meshless solid in total-Lagrangian form.

F = I + Σ u_a ⊗ ∇p_a and f_a = -Σ_q w_q P(F_q) ∇p_a(q) over quadrature points of the cells, with gradients by the reference
configuration, found once (Horton et al. 2010, Int. J. Numer. Methods Biomed. Eng. 26, 977; Mountris et al. 2019, section 4).

Nearly incompressible solids would lock: their volume ratio is averaged about the corners a of the cells, with the linear
functions N_a, J̄_a = Σ_q w N_a J / V_a, V_a = Σ_q w N_a, and the volumetric part U(J) of the energy is taken of J̄_a, V_a
each: P = ∂W/∂F + (Σ_a N_a U'(J̄_a) - U'(J)) cof F. (The average nodal pressure of Bonet & Burton 1998, Commun. Numer. Methods
Eng. 14, 437, for linear tetrahedra.)

Four points stand side by side in the lanes of a vector: a pack. Gradients are kept as ∇p_a = Kᵀ g_a, with g_a in single
precision that add up to nothing to the last bit, and K, one to a point, that puts linear reproduction right to the precision
of doubles: forces and torques of the whole solid vanish to round-off of doubles, whatever the precision of the g_a.

Packs are shared out in blocks that do not depend on the threads. A block sums what it gives to its own nodes; each node then
adds up what its blocks have, in their order.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for
from pellucid.jit.vector import LANES, load, splat, spread, store, total, totals
from pellucid.materials.law import energy_and_stress, volumetric_energy, volumetric_stress
from pellucid.tensors import cofactor, determinant

PACKS = 512  # of a block
BATCH = 8  # packs whose stresses are found side by side
COLUMN = BATCH * LANES
CHUNK = 2048  # nodes
ENERGY, LEAST_J = range(2)  # columns of the sums of a block
DEFORMATION, NODAL, WEIGHT, STRESS, STORED, RATIO, COLUMNS = 0, 9, 10, 11, 20, 21, 22  # of a batch


class Blocks(NamedTuple):
    """The nodes of each block of packs, and the places of each node in the blocks."""

    first: np.ndarray  # (blocks + 1,)
    nodes: np.ndarray  # those of block b from first[b] to first[b + 1]
    node_first: np.ndarray  # (n + 1,)
    places: np.ndarray  # of node a in `nodes`, from node_first[a] to node_first[a + 1], ascending


class Functions(NamedTuple):
    """Lists of nodes of the packs, and what belongs to each entry: its node's place in the block, times the lanes, and numbers
    of the points of the pack, component by component."""

    first: np.ndarray  # (packs + 1,)
    place: np.ndarray
    numbers: np.ndarray


class Solid(NamedTuple):
    """What kernels take of a solid."""

    law: Any
    n_points: int  # of a cell
    gradients: Functions  # g_a [1/m], 3 × LANES numbers to an entry
    turns: np.ndarray  # K - I of the points, 9 × LANES to a pack
    corners: Functions  # w N_a [m³] of the corners, LANES to an entry
    weights: np.ndarray  # w [m³], LANES to a pack; no volume where there is no point
    blocks: Blocks
    displacement: np.ndarray  # (n, 3) [m]
    deformation: np.ndarray  # deformation gradients, 9 × LANES to a pack
    block_force: np.ndarray  # (places, 3) [N]
    block_volume: np.ndarray  # (places,) Σ w N_a J of each block, no rows where J is not averaged
    volume: np.ndarray  # (n,) V_a [m³]
    volume_ratio: np.ndarray  # (n,) J̄_a
    mean_stress: np.ndarray  # (n,) U'(J̄_a) [Pa]
    sums: np.ndarray  # (blocks, 2)
    node_sums: np.ndarray  # (chunks, 2)


def deformation_gradients(solid: Solid, n_cells: int) -> np.ndarray:
    """Of the points of each cell, shape (n_cells, points, 3, 3)."""
    points = solid.deformation.reshape(-1, 9, LANES).swapaxes(1, 2)
    return points.reshape(-1, 3, 3)[: n_cells * solid.n_points].reshape(n_cells, solid.n_points, 3, 3)


@kernel(inner=True)
def _turned(x, y, z, K, at, step):
    return x * load(K, at) + y * load(K, at + step) + z * load(K, at + 2 * step)


@kernel(inner=True)
def _deform(pack, solid, u, F, at, step):
    """Put the deformation gradients of a pack into F from `at` on, components a step apart; u: displacements of the block."""
    G, first, end = solid.gradients.numbers, solid.gradients.first[pack], solid.gradients.first[pack + 1]
    place, zero = solid.gradients.place[first:end], splat(0.0)
    a, b, c, d, e, f, g, h, i = zero, zero, zero, zero, zero, zero, zero, zero, zero
    for entry in range(end - first):
        k, node = 3 * LANES * (first + entry), place[entry]
        x, y, z = load(G, k), load(G, k + LANES), load(G, k + 2 * LANES)
        ux, uy, uz = spread(u, node), spread(u, node + 1), spread(u, node + 2)
        a, b, c = a + ux * x, b + ux * y, c + ux * z
        d, e, f = d + uy * x, e + uy * y, f + uy * z
        g, h, i = g + uz * x, h + uz * y, i + uz * z
    K, k = solid.turns, 9 * LANES * pack
    one, two, three = k, k + LANES, k + 2 * LANES
    store(F, at, 1.0 + (a + _turned(a, b, c, K, one, 3 * LANES)))
    store(F, at + step, b + _turned(a, b, c, K, two, 3 * LANES))
    store(F, at + 2 * step, c + _turned(a, b, c, K, three, 3 * LANES))
    store(F, at + 3 * step, d + _turned(d, e, f, K, one, 3 * LANES))
    store(F, at + 4 * step, 1.0 + (e + _turned(d, e, f, K, two, 3 * LANES)))
    store(F, at + 5 * step, f + _turned(d, e, f, K, three, 3 * LANES))
    store(F, at + 6 * step, g + _turned(g, h, i, K, one, 3 * LANES))
    store(F, at + 7 * step, h + _turned(g, h, i, K, two, 3 * LANES))
    store(F, at + 8 * step, 1.0 + (i + _turned(g, h, i, K, three, 3 * LANES)))


@kernel(inner=True)
def pull(pack, solid, P, at, f):
    """Take P ∇p_a from the forces f of the block: P, times the weights, in P from `at` on, components a column apart."""
    K, k = solid.turns, 9 * LANES * pack
    one, two, three = k, k + 3 * LANES, k + 6 * LANES
    x, y, z = load(P, at), load(P, at + COLUMN), load(P, at + 2 * COLUMN)
    a, b = x + _turned(x, y, z, K, one, LANES), y + _turned(x, y, z, K, two, LANES)
    c = z + _turned(x, y, z, K, three, LANES)
    x, y, z = load(P, at + 3 * COLUMN), load(P, at + 4 * COLUMN), load(P, at + 5 * COLUMN)
    d, e = x + _turned(x, y, z, K, one, LANES), y + _turned(x, y, z, K, two, LANES)
    g = z + _turned(x, y, z, K, three, LANES)
    x, y, z = load(P, at + 6 * COLUMN), load(P, at + 7 * COLUMN), load(P, at + 8 * COLUMN)
    h, i = x + _turned(x, y, z, K, one, LANES), y + _turned(x, y, z, K, two, LANES)
    j = z + _turned(x, y, z, K, three, LANES)
    G, first, end = solid.gradients.numbers, solid.gradients.first[pack], solid.gradients.first[pack + 1]
    place = solid.gradients.place[first:end]
    for entry in range(end - first):
        k, node = 3 * LANES * (first + entry), place[entry]
        x, y, z = load(G, k), load(G, k + LANES), load(G, k + 2 * LANES)
        store(f, node, load(f, node) - totals(a * x + b * y + c * z, d * x + e * y + g * z, h * x + i * y + j * z))


@kernel(inner=True)
def _find_stresses(law, averaged, s):
    """Replace what a batch of points has in columns of s: stored energy and P, times the weights, and the volume ratio."""
    for i in range(COLUMN):  # columns a constant apart, and no other array: the compiler takes several points at a time
        F = (
            s[i],
            s[COLUMN + i],
            s[2 * COLUMN + i],
            s[3 * COLUMN + i],
            s[4 * COLUMN + i],
            s[5 * COLUMN + i],
            s[6 * COLUMN + i],
            s[7 * COLUMN + i],
            s[8 * COLUMN + i],
        )
        w, J = s[WEIGHT * COLUMN + i], determinant(F)
        stored, P = energy_and_stress(law, F)
        extra = 0.0
        if averaged:
            stored -= volumetric_energy(law, J)
            extra = s[NODAL * COLUMN + i] - w * volumetric_stress(law, J)
        C = cofactor(F)
        s[STRESS * COLUMN + i] = w * P[0] + extra * C[0]
        s[(STRESS + 1) * COLUMN + i] = w * P[1] + extra * C[1]
        s[(STRESS + 2) * COLUMN + i] = w * P[2] + extra * C[2]
        s[(STRESS + 3) * COLUMN + i] = w * P[3] + extra * C[3]
        s[(STRESS + 4) * COLUMN + i] = w * P[4] + extra * C[4]
        s[(STRESS + 5) * COLUMN + i] = w * P[5] + extra * C[5]
        s[(STRESS + 6) * COLUMN + i] = w * P[6] + extra * C[6]
        s[(STRESS + 7) * COLUMN + i] = w * P[7] + extra * C[7]
        s[(STRESS + 8) * COLUMN + i] = w * P[8] + extra * C[8]
        s[STORED * COLUMN + i] = w * stored
        s[RATIO * COLUMN + i] = J


@kernel(inner=True)
def displacements(start, m, solid):
    """Of the m nodes of a block, a vector for each."""
    u = np.zeros(LANES * m)
    for k in range(m):
        for d in range(3):
            u[LANES * k + d] = solid.displacement[solid.blocks.nodes[start + k], d]
    return u


@kernel(inner=True)
def deform_block(block, solid):
    """Deformation gradients of a block, and what it gives to the volumes about the nodes."""
    start, end = solid.blocks.first[block], solid.blocks.first[block + 1]
    u, volume, corners = displacements(start, end - start, solid), solid.block_volume[start:end], solid.corners
    volume[:] = 0.0
    for pack in range(PACKS * block, min(PACKS * (block + 1), len(corners.first) - 1)):
        at = 9 * LANES * pack
        _deform(pack, solid, u, solid.deformation, at, LANES)
        F = _components(solid.deformation, at, LANES)
        J = determinant(F)
        for entry in range(corners.first[pack], corners.first[pack + 1]):
            volume[corners.place[entry] // LANES] += total(J * load(corners.numbers, LANES * entry))


@kernel(inner=True)
def _components(s, at, step):
    """The nine components of vectors that stand a step apart."""
    first = (load(s, at), load(s, at + step), load(s, at + 2 * step), load(s, at + 3 * step), load(s, at + 4 * step))
    last = (load(s, at + 5 * step), load(s, at + 6 * step), load(s, at + 7 * step), load(s, at + 8 * step))
    return (first[0], first[1], first[2], first[3], first[4], last[0], last[1], last[2], last[3])


@kernel(inner=True)
def average_chunk(chunk, solid):
    """Volume ratios of nodes, the energy in them and their stresses."""
    blocks, least, stored = solid.blocks, np.inf, 0.0
    for a in range(CHUNK * chunk, min(CHUNK * (chunk + 1), len(solid.volume))):
        volume = 0.0
        for place in range(blocks.node_first[a], blocks.node_first[a + 1]):
            volume += solid.block_volume[blocks.places[place]]
        J = solid.volume_ratio[a] = volume / solid.volume[a]
        least = min(least, J)
        stored += solid.volume[a] * volumetric_energy(solid.law, J)
        solid.mean_stress[a] = volumetric_stress(solid.law, J)
    solid.node_sums[chunk, ENERGY], solid.node_sums[chunk, LEAST_J] = stored, least


@kernel(inner=True)
def fill_batch(first, n, solid, averaged, mean, u, s):
    """Put deformation gradients, weights and nodal means of n packs into columns of s; u, mean: of the nodes of the block."""
    corners = solid.corners
    for k in range(n):
        pack, here = first + k, 9 * LANES * (first + k)
        store(s, WEIGHT * COLUMN + k * LANES, load(solid.weights, LANES * pack))
        if averaged:
            extra = splat(0.0)
            for entry in range(corners.first[pack], corners.first[pack + 1]):
                extra += spread(mean, corners.place[entry] // LANES) * load(corners.numbers, LANES * entry)
            store(s, NODAL * COLUMN + k * LANES, extra)
        else:
            _deform(pack, solid, u, solid.deformation, here, LANES)
        for i in range(9):
            store(s, i * COLUMN + k * LANES, load(solid.deformation, here + i * LANES))


@kernel(inner=True)
def mean_stresses(start, m, solid):
    """Of the m nodes of a block, where the volume ratio is averaged."""
    mean = np.zeros(m)
    if len(solid.block_volume) > 0:
        for k in range(m):
            mean[k] = solid.mean_stress[solid.blocks.nodes[start + k]]
    return mean


@kernel(inner=True)
def end_block(block, solid, f, stored, least):
    """Keep the forces f of a block, a vector for each of its nodes, its stored energy and its least volume ratio."""
    start = solid.blocks.first[block]
    for k in range(solid.blocks.first[block + 1] - start):
        for d in range(3):
            solid.block_force[start + k, d] = f[LANES * k + d]
    solid.sums[block, ENERGY], solid.sums[block, LEAST_J] = total(stored), least


@kernel(inner=True)
def _force_block(block, solid):
    """Forces of a block on its nodes; where the volume ratio is not averaged, the deformation gradients too."""
    blocks, corners, averaged = solid.blocks, solid.corners, len(solid.block_volume) > 0
    start, m = blocks.first[block], blocks.first[block + 1] - blocks.first[block]
    u = displacements(start, m, solid)
    f, mean, s = np.zeros(LANES * m), mean_stresses(start, m, solid), np.zeros(COLUMNS * COLUMN)
    stored, least, end = splat(0.0), np.inf, min(PACKS * (block + 1), len(corners.first) - 1)
    for first in range(PACKS * block, end, BATCH):
        n = min(BATCH, end - first)
        fill_batch(first, n, solid, averaged, mean, u, s)
        _find_stresses(solid.law, averaged, s)
        for k in range(n):
            pull(first + k, solid, s, STRESS * COLUMN + k * LANES, f)
            stored += load(s, STORED * COLUMN + k * LANES)
            for lane in range(LANES):
                least = min(least, s[RATIO * COLUMN + k * LANES + lane])
    end_block(block, solid, f, stored, least)


@kernel(inner=True)
def add_blocks(chunk, solid, force):
    """Forces of a chunk of the nodes, from what their blocks have of them."""
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
    if len(solid.block_volume) > 0:
        parallel_for(deform_block, n_blocks, solid)
        parallel_for(average_chunk, chunks, solid)
    parallel_for(_force_block, n_blocks, solid)
    parallel_for(add_blocks, chunks, solid, force)
