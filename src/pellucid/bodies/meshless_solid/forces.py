"""Internal forces of a meshless solid in total-Lagrangian form.

F = I + Σ u_a ⊗ ∇p_a and f_a = -Σ_q w_q P(F_q) ∇p_a(q) over quadrature points of the cells, with gradients by the reference
configuration, found once (Horton et al. 2010, Int. J. Numer. Methods Biomed. Eng. 26, 977; Mountris et al. 2019, section 4).
Cells are shared out in blocks that do not depend on the threads. A block sums the forces of its own nodes; each node then
adds up what its blocks have, in their order.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.approximants.nodal.rings import Lists
from pellucid.jit import kernel
from pellucid.jit.parallel import parallel_for
from pellucid.materials.law import energy, first_piola_kirchhoff
from pellucid.tensors import determinant

CELLS = 1024  # of a block
CHUNK = 2048  # nodes


class Blocks(NamedTuple):
    """The nodes of each block of cells, and the places of each node in the blocks."""

    first: np.ndarray  # (blocks + 1,)
    nodes: np.ndarray  # those of block b from first[b] to first[b + 1]
    local: np.ndarray  # for each entry of the cells' lists, the number of its node within the block
    node_first: np.ndarray  # (n + 1,)
    places: np.ndarray  # of node a in `nodes`, from node_first[a] to node_first[a + 1], ascending


class Quadrature(NamedTuple):
    """What kernels take of a solid."""

    law: Any
    n_points: int  # of a cell
    first: np.ndarray  # of each cell's active nodes
    gradients: np.ndarray  # [cell][point][direction][node] [1/m]
    weights: np.ndarray  # (c,) volume of each point of a cell [m³]
    blocks: Blocks
    displacement: np.ndarray  # (n, 3) [m]
    block_force: np.ndarray  # (places, 3) [N]
    sums: np.ndarray  # (blocks, 2) strain energy [J], least determinant of F


def make_blocks(active: Lists, n_nodes: int) -> Blocks:
    """Blocks of cells for lists of their active nodes."""
    n_blocks = (len(active.first) - 2) // CELLS + 1
    block = np.repeat(np.arange(len(active.first) - 1) // CELLS, np.diff(active.first))
    pairs, local = np.unique(block * n_nodes + active.items, return_inverse=True)
    first = np.searchsorted(pairs, np.arange(n_blocks + 1) * n_nodes)
    nodes = pairs % n_nodes
    places = np.argsort(nodes, kind="stable")
    node_first = np.searchsorted(nodes[places], np.arange(n_nodes + 1))
    return Blocks(first, nodes, (local.ravel() - first[block]).astype(np.int32), node_first, places)


@kernel(inner=True, reorder=True)
def _deformation_gradient(x, y, z, u, v, w):
    """F from the gradients (x, y, z) and displacements (u, v, w) of the nodes of a cell, shape (n,) each."""
    a = b = c = d = e = f = g = h = i = 0.0
    for k in range(len(x)):
        a, b, c = a + u[k] * x[k], b + u[k] * y[k], c + u[k] * z[k]
        d, e, f = d + v[k] * x[k], e + v[k] * y[k], f + v[k] * z[k]
        g, h, i = g + w[k] * x[k], h + w[k] * y[k], i + w[k] * z[k]
    return (1.0 + a, b, c, d, 1.0 + e, f, g, h, 1.0 + i)


@kernel(inner=True)
def _add_forces(P, x, y, z, f, g, h):
    """Take P ∇p_a from the forces (f, g, h) of the nodes of a cell."""
    for k in range(len(x)):
        f[k] -= P[0] * x[k] + P[1] * y[k] + P[2] * z[k]
        g[k] -= P[3] * x[k] + P[4] * y[k] + P[5] * z[k]
        h[k] -= P[6] * x[k] + P[7] * y[k] + P[8] * z[k]


@kernel(inner=True)
def _forces_block(block, solid):
    blocks, G, nq = solid.blocks, solid.gradients, solid.n_points
    start, end = blocks.first[block], blocks.first[block + 1]
    m = end - start
    u, f = np.empty(3 * m), np.zeros(3 * m)
    for k in range(m):
        for d in range(3):
            u[d * m + k] = solid.displacement[blocks.nodes[start + k], d]
    local_u, local_f = np.empty(3 * 512), np.empty(3 * 512)
    total, least = 0.0, 1.0e300
    for cell in range(CELLS * block, min(CELLS * (block + 1), len(solid.weights))):
        here = solid.first[cell]
        n = solid.first[cell + 1] - here
        w = solid.weights[cell]
        for k in range(n):
            place = blocks.local[here + k]
            for d in range(3):
                local_u[d * n + k] = u[d * m + place]
                local_f[d * n + k] = 0.0
        ux, uy, uz = local_u[:n], local_u[n : 2 * n], local_u[2 * n : 3 * n]
        fx, fy, fz = local_f[:n], local_f[n : 2 * n], local_f[2 * n : 3 * n]
        for q in range(nq):
            at = 3 * (nq * here + q * n)
            x, y, z = G[at : at + n], G[at + n : at + 2 * n], G[at + 2 * n : at + 3 * n]
            F = _deformation_gradient(x, y, z, ux, uy, uz)
            P = first_piola_kirchhoff(solid.law, F)
            total += w * energy(solid.law, F)
            least = min(least, determinant(F))
            P = (w * P[0], w * P[1], w * P[2], w * P[3], w * P[4], w * P[5], w * P[6], w * P[7], w * P[8])
            _add_forces(P, x, y, z, fx, fy, fz)
        for k in range(n):
            place = blocks.local[here + k]
            for d in range(3):
                f[d * m + place] += local_f[d * n + k]
    for k in range(m):
        for d in range(3):
            solid.block_force[start + k, d] = f[d * m + k]
    solid.sums[block, 0], solid.sums[block, 1] = total, least


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
    """Fill force (n, 3) [N], and the sums of the blocks."""
    parallel_for(_forces_block, n_blocks, solid)
    parallel_for(_add_blocks, chunks, solid, force)
