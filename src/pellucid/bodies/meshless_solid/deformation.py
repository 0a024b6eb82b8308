"""Kernels for deformation gradients from nodal displacements, and nodal forces from stresses.

They process packs of four quadrature points (SIMD vectors). A block is a group of packs with a common list of nodes.
"""

import numpy as np

from pellucid.bodies.meshless_solid.solid import COLUMN, PACKS
from pellucid.jit import kernel
from pellucid.jit.vector import LANES, load, splat, spread, store, total, totals
from pellucid.tensors import determinant


@kernel(inner=True)
def _turned(x, y, z, K, at, step):
    return x * load(K, at) + y * load(K, at + step) + z * load(K, at + 2 * step)


@kernel(inner=True)
def deform(pack, mesh, u, F, at, step):
    """Write the deformation gradients of a pack (four quadrature points) to F: the first component at index `at`, the others
    at a fixed step apart. mesh: data of `Solid`; u: nodal displacements of the block [m], LANES numbers per node.
    """
    G, first, end = mesh.gradients.numbers, mesh.gradients.first[pack], mesh.gradients.first[pack + 1]
    place, zero = mesh.gradients.place[first:end], splat(0.0)
    a, b, c, d, e, f, g, h, i = zero, zero, zero, zero, zero, zero, zero, zero, zero
    for entry in range(end - first):
        k, node = 3 * LANES * (first + entry), place[entry]
        x, y, z = load(G, k), load(G, k + LANES), load(G, k + 2 * LANES)
        ux, uy, uz = spread(u, node), spread(u, node + 1), spread(u, node + 2)
        a, b, c = a + ux * x, b + ux * y, c + ux * z
        d, e, f = d + uy * x, e + uy * y, f + uy * z
        g, h, i = g + uz * x, h + uz * y, i + uz * z
    K, k = mesh.turns, 9 * LANES * pack
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
def pull(pack, mesh, P, at, f):
    """Subtract P ∇p_a, with the first Piola-Kirchhoff stress P, from the forces f on the nodes a of a block, for a pack (four
    quadrature points).

    mesh: data of `Solid`; P: stresses of the pack times the quadrature weights, the first component at index `at`, the others
    COLUMN apart; f: forces [N], LANES numbers per node.
    """
    K, k = mesh.turns, 9 * LANES * pack
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
    G, first, end = mesh.gradients.numbers, mesh.gradients.first[pack], mesh.gradients.first[pack + 1]
    place = mesh.gradients.place[first:end]
    for entry in range(end - first):
        k, node = 3 * LANES * (first + entry), place[entry]
        x, y, z = load(G, k), load(G, k + LANES), load(G, k + 2 * LANES)
        store(f, node, load(f, node) - totals(a * x + b * y + c * z, d * x + e * y + g * z, h * x + i * y + j * z))


@kernel(inner=True, allocates=True)
def displacements(start, m, mesh):
    """Return the displacements [m] of the m nodes of a block (a group of packs of quadrature points), padded to one SIMD vector
    for each node. start: index of the first of these nodes in the node list of the blocks; mesh: data of `Solid`.
    """
    u = np.zeros(LANES * m)
    for k in range(m):
        for d in range(3):
            u[LANES * k + d] = mesh.displacement[mesh.blocks.nodes[start + k], d]
    return u


@kernel(inner=True)
def deform_block(block, mesh):
    """Compute the deformation gradients at the quadrature points of a block (a group of packs of four points), and the
    contributions of these points to the volumes around the nodes; both are stored in `mesh` (data of `Solid`).
    """
    start, end = mesh.blocks.first[block], mesh.blocks.first[block + 1]
    u, volume, corners = displacements(start, end - start, mesh), mesh.block_volume[start:end], mesh.corners
    volume[:] = 0.0
    for pack in range(PACKS * block, min(PACKS * (block + 1), len(corners.first) - 1)):
        at = 9 * LANES * pack
        deform(pack, mesh, u, mesh.deformation, at, LANES)
        F = components(mesh.deformation, at, LANES)
        J = determinant(F)
        for entry in range(corners.first[pack], corners.first[pack + 1]):
            volume[corners.place[entry] // LANES] += total(J * load(corners.numbers, LANES * entry))


@kernel(inner=True)
def components(s, at, step):
    """Return the nine components of a tensor, as SIMD vectors read from the array s: the first at index `at`, the others a
    step apart.
    """
    first = (load(s, at), load(s, at + step), load(s, at + 2 * step), load(s, at + 3 * step), load(s, at + 4 * step))
    last = (load(s, at + 5 * step), load(s, at + 6 * step), load(s, at + 7 * step), load(s, at + 8 * step))
    return (first[0], first[1], first[2], first[3], first[4], last[0], last[1], last[2], last[3])
