"""Data of a meshless solid for kernels: quadrature points in packs, packs in blocks, and shape functions at the points.

A pack is four points in the lanes of a SIMD vector. Gradients are stored as ∇p_a = Kᵀ g_a. The g_a are in single precision and
sum to exactly zero; K, one per point, restores linear reproduction to double precision. Forces and torques of the whole solid
therefore vanish to double-precision round-off, whatever the precision of the g_a. Packs are divided into blocks that do not
depend on the number of threads. A block sums the forces on its own nodes; each node then sums the contributions of its blocks
in a fixed order.
"""

from typing import Any, NamedTuple

import numpy as np

from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit.vector import LANES
from pellucid.parts.body import in_metres

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
