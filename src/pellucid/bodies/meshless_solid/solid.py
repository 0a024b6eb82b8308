"""Data of a meshless solid for kernels: quadrature points in packs, packs in blocks, and shape functions at the points.

A pack is four points in the lanes of a SIMD vector. Gradients are stored as ∇p_a = Kᵀ g_a. The g_a are in single precision and
sum to exactly zero; K, one per point, restores linear reproduction to double precision. Forces and torques of the whole solid
therefore vanish to double-precision round-off, whatever the precision of the g_a. Packs are divided into blocks that do not
depend on the number of threads. A block sums the forces on its own nodes; each node then sums the contributions of its blocks
in a fixed order.
"""

from math import frexp, ldexp
from typing import Any, NamedTuple

import numpy as np

from pellucid.approximants.nodal.contract import Lists
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES, load, splat, spread, store, total, totals
from pellucid.parts.body import in_metres
from pellucid.tensors import cofactor, determinant

PACKS = 512  # packs in a block
BATCH = 8  # packs whose stresses are computed together
COLUMN = BATCH * LANES
CHUNK = 2048  # nodes
ENERGY, LEAST_J, LOST = range(3)  # columns of `sums`: energy, smallest volume ratio, dissipated energy
NODAL, WEIGHT, STRESS, STORED, RATIO, COLUMNS = (
    9,
    10,
    11,
    20,
    21,
    22,
)  # columns of a batch after the nine of the deformation gradient


class Blocks(NamedTuple):
    """The nodes of each block of packs (groups of four quadrature points), and the entries of each node in the blocks."""

    first: np.ndarray  # (blocks + 1,) index in `nodes` of the first node of each block
    nodes: np.ndarray  # (places,) nodes of block b from first[b] to first[b + 1]
    node_first: np.ndarray  # (n + 1,) index in `places` of the first entry of each node
    places: np.ndarray  # (places,) indices in `nodes` of node a, from node_first[a] to node_first[a + 1], ascending


class Functions(NamedTuple):
    """Shape functions or gradients at the quadrature points, arranged in packs (SIMD vectors of points), and packs in blocks.
    A pack has one entry for each of its nodes: the node's index in the block times the number of lanes, and the values at the
    points of the pack, component by component.
    """

    first: np.ndarray  # (packs + 1,) index of the first entry of each pack
    place: np.ndarray  # (entries,) index of the node in the block, times the number of lanes
    numbers: np.ndarray  # values at the points of the pack, entry by entry


class Elastic(NamedTuple):
    """Material points whose stresses depend on the present deformation only."""

    law: Any  # hyperelastic law


class Solid(NamedTuple):
    """Data of a meshless solid for kernels: material, shape functions at the quadrature points, present state, and results
    of the kernels.

    Quadrature points are arranged in packs of four, the lanes of a SIMD vector, and packs in blocks. The gradients of the
    shape functions are ∇p_a = Kᵀ g_a, with g_a in single precision and one tensor K per point. J: volume ratio at a point;
    J̄_a: average of J around node a, with the linear functions N_a of the cells; U: volumetric energy of the law.
    """

    law: Any  # hyperelastic law
    points: Any  # material points, see `find_stresses`: `Elastic`, or a type with history variables
    n_points: int  # quadrature points per cell
    gradients: Functions  # g_a [1/m], 3 × LANES numbers per entry
    turns: np.ndarray  # K - I of the points, 9 × LANES numbers per pack
    corners: Functions  # w N_a [m³] of the corners a of the cells, LANES numbers per entry
    weights: np.ndarray  # quadrature weights w [m³], LANES numbers per pack; 0 for lanes without a point
    blocks: Blocks  # nodes of the blocks
    displacement: np.ndarray  # (n, 3) nodal displacements [m]
    deformation: np.ndarray  # deformation gradients, 9 × LANES numbers per pack
    block_force: np.ndarray  # (places, 3) forces of each block on its nodes [N]
    block_volume: np.ndarray  # (places,) Σ w N_a J of each block [m³]; empty unless J is averaged
    volume: np.ndarray  # (n,) reference volume V_a around each node [m³]
    volume_ratio: np.ndarray  # (n,) averaged volume ratio J̄_a
    mean_stress: np.ndarray  # (n,) mean volumetric stress U'(J̄_a) [Pa]
    sums: np.ndarray  # (blocks, 3) columns ENERGY, LEAST_J and LOST
    node_sums: np.ndarray  # (chunks, 2) columns ENERGY and LEAST_J of chunks of nodes


def nodes_of_entries(functions: Functions, blocks: Blocks) -> np.ndarray:
    """Return the node of each entry of shape functions, shape (entries,)."""
    counts = np.diff(functions.first)
    start = np.repeat(blocks.first[np.arange(len(counts)) // PACKS], counts)
    return np.asarray(blocks.nodes[start + functions.place // LANES])


def deformation_gradients(solid: Solid, n_cells: int) -> np.ndarray:
    """Return the deformation gradients at the quadrature points of each cell, shape (n_cells, points, 3, 3)."""
    points = solid.deformation.reshape(-1, 9, LANES).swapaxes(1, 2)
    return points.reshape(-1, 3, 3)[: n_cells * solid.n_points].reshape(n_cells, solid.n_points, 3, 3)


def inversion(mesh: SimplexMesh, solid: Solid) -> tuple[str, int] | None:
    """Return a text about the location of an inverted quadrature point, and the number of a node of its cell; or of a node
    with a non-positive mean volume ratio, and its number. None if the solid has neither."""
    if not solid.sums[:, LEAST_J].min() > 0.0:
        ratios = np.linalg.det(deformation_gradients(solid, len(mesh.cells)))
        cell = int(np.argmin(ratios)) // solid.n_points
        corners = mesh.cells[cell]
        named, place = ", ".join(map(str, sorted(corners.tolist()))), in_metres(mesh.nodes[corners].mean(axis=0))
        words = f"between nodes {named}, where {place} was at rest: the volume ratio of a point is {ratios.min():.3g}"
        return words, int(corners[0])
    if len(solid.block_volume) and not solid.node_sums[:, LEAST_J].min() > 0.0:
        node = int(np.argmin(solid.volume_ratio))
        place, ratio = in_metres(mesh.nodes[node]), solid.volume_ratio[node]
        return f"about node {node}, where {place} was at rest: the mean volume ratio about it is {ratio:.3g}", node
    return None


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


PACKS_AT_ONCE = 256  # packs that one thread processes at a time
DIGITS = 24  # binary digits of a number in single precision


class Source(NamedTuple):
    """Shape-function data to be rearranged into packs (four quadrature points), with the node lists of cells and packs. The
    numbers at a point are sorted by component, and for each component by node of the cell.
    """

    n_points: int  # quadrature points per cell
    cells: Lists  # nodes of each cell
    packs: Lists  # nodes of each pack
    numbers: np.ndarray  # data, point by point


def pack_lists(cells: Lists, n_points: int) -> Lists:
    """Return the nodes of each pack (four quadrature points), from the nodes of each cell in ascending order. n_points:
    quadrature points per cell.
    """
    count, n_cells = np.diff(cells.first), len(cells.first) - 1
    if n_points % LANES == 0:
        times = n_points // LANES
        first = np.concatenate([[0], np.cumsum(np.repeat(count, times))])
        shift = np.repeat(np.repeat(cells.first[:-1], times) - first[:-1], np.diff(first))
        return Lists(first, cells.items[shift + np.arange(int(first[-1]))])
    size = LANES // n_points
    n, n_packs = int(cells.items.max()) + 1, -(-n_cells // size)
    keys = np.unique(np.repeat(np.arange(n_cells) // size, count) * n + cells.items)
    return Lists(np.searchsorted(keys, np.arange(n_packs + 1) * n), keys % n)


@kernel(inner=True)
def _take(pack, source, parts, out):
    """Fill `out` with the numbers of one pack (LANES quadrature points): for each of its nodes `parts` components at LANES
    points; zero for missing points. source: data of `Source`.
    """
    nq, cells, packs = source.n_points, source.cells, source.packs
    start, end = packs.first[pack], packs.first[pack + 1]
    out[: parts * LANES * (end - start)] = 0.0
    for lane in range(LANES):
        cell, q = (LANES * pack + lane) // nq, (LANES * pack + lane) % nq
        if cell >= len(cells.first) - 1:
            break
        n, entry = cells.first[cell + 1] - cells.first[cell], start
        at = parts * (nq * cells.first[cell] + q * n)
        for k in range(n):
            while packs.items[entry] < cells.items[cells.first[cell] + k]:
                entry += 1
            for part in range(parts):
                out[(parts * (entry - start) + part) * LANES + lane] = source.numbers[at + part * n + k]


@parallel_loop()
def _fill(chunk, source, parts, out):
    first = source.packs.first
    for pack in range(PACKS_AT_ONCE * chunk, min(PACKS_AT_ONCE * (chunk + 1), len(first) - 1)):
        _take(pack, source, parts, out[parts * LANES * first[pack] : parts * LANES * first[pack + 1]])


@kernel(inner=True)
def _round_together(n, step, numbers):
    """Round n numbers, a step apart in an array, whose exact sum is zero, in place, to multiples of the single-precision unit
    of the largest one.

    The partial sums are rounded, so that the rounded numbers, their differences, sum to exactly zero.
    """
    largest = 0.0
    for k in range(n):
        largest = max(largest, abs(numbers[k * step]))
    if largest == 0.0:
        return
    unit = ldexp(1.0, frexp(largest)[1] - DIGITS)
    total = before = 0.0
    for k in range(n):
        total += numbers[k * step] / unit
        here = np.rint(total) if k < n - 1 else 0.0
        numbers[k * step] = (here - before) * unit
        before = here


@kernel(inner=True, allocates=True)
def _turn(n, lane, nodes, position, g, K):
    """Compute K - I with K = (Σ x_a ⊗ g_a)⁻¹ at a point, so that the gradients Kᵀ g_a reproduce linear functions.

    n: number of nodes a; lane: position of the point in its pack; nodes: the nodes; position: x_a [m], shape (all nodes, 3);
    g: rounded gradients of the pack [1/m]; K: receives the result.
    """
    D = np.zeros((3, 3))
    for k in range(n):
        for i in range(3):
            x = position[nodes[k], i] - position[nodes[0], i]
            for j in range(3):
                D[i, j] += x * g[(3 * k + j) * LANES + lane]
    E = (D[0, 0], D[0, 1], D[0, 2], D[1, 0], D[1, 1], D[1, 2], D[2, 0], D[2, 1], D[2, 2])
    over, C = 1.0 / determinant(E), cofactor(E)
    for i in range(3):
        for j in range(3):
            K[(3 * i + j) * LANES + lane] = over * C[3 * j + i] - (i == j)


@parallel_loop(allocates=True)
def _fill_gradients(chunk, source, position, longest, rounded, gradients, turns):
    first, nodes, nq = source.packs.first, source.packs.items, source.n_points
    g = np.empty(3 * LANES * longest)
    for pack in range(PACKS_AT_ONCE * chunk, min(PACKS_AT_ONCE * (chunk + 1), len(first) - 1)):
        n = first[pack + 1] - first[pack]
        _take(pack, source, 3, g)
        for lane in range(min(LANES, nq * (len(source.cells.first) - 1) - LANES * pack)):
            if rounded:
                for axis in range(3):
                    _round_together(n, 3 * LANES, g[axis * LANES + lane :])
            _turn(n, lane, nodes[first[pack] : first[pack + 1]], position, g, turns[9 * LANES * pack : 9 * LANES * (pack + 1)])
        for k in range(3 * LANES * n):
            gradients[3 * LANES * first[pack] + k] = g[k]


def pack_numbers(cells: Lists, packs: Lists, n_points: int, numbers: np.ndarray) -> np.ndarray:
    """Rearrange data with one number per node and quadrature point into packs (four points): LANES numbers per entry of the
    packs' node lists.

    cells, packs: nodes of each cell and pack; n_points: quadrature points per cell; numbers: data, point by point.
    """
    out, chunks = np.empty(LANES * len(packs.items)), -(-(len(packs.first) - 1) // PACKS_AT_ONCE)
    _fill(chunks, Bundle(Source(n_points, cells, packs, numbers)), 1, out)
    return out


def pack_gradients(
    cells: Lists, packs: Lists, n_points: int, rows: np.ndarray, position: np.ndarray, storage: Any
) -> tuple[np.ndarray, np.ndarray]:
    """Rearrange gradients of shape functions into packs (four points), as rounded gradients g_a and a correction K with ∇p_a =
    Kᵀ g_a.

    Returns g_a, 3 × LANES numbers of type `storage` per entry of the node lists, and K - I, 9 × LANES numbers per pack. cells,
    packs: nodes of each cell and pack; n_points: quadrature points per cell; rows: gradients [1/m], point by point; position:
    nodal positions [m], shape (n, 3). In single precision the g_a of each point sum to exactly zero.
    """
    n_packs = len(packs.first) - 1
    gradients, turns = np.empty(3 * LANES * len(packs.items), storage), np.zeros(9 * LANES * n_packs, storage)
    longest, rounded = int(np.diff(packs.first).max()), np.dtype(storage) == np.float32
    source = Bundle(Source(n_points, cells, packs, rows))
    _fill_gradients(-(-n_packs // PACKS_AT_ONCE), source, position, longest, rounded, gradients, turns)
    return gradients, turns
