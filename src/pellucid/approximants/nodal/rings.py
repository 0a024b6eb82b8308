"""Rings of cells around nodes, and their boundaries: the supports of cell-based approximants.

The first ring of a node is the cells that contain it; the k-th ring is the cells that contain a node of the previous ring
(Millán, Sukumar & Arroyo 2015, Comput. Methods Appl. Mech. Eng. 284, 712).
"""

from typing import TYPE_CHECKING

import numpy as np
from scipy import sparse
from scipy.spatial import cKDTree

from pellucid.approximants.nodal.contract import Lists
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh

BLOCK = 4096  # number of nodes whose rings are processed at a time, to limit memory

if TYPE_CHECKING:
    from pellucid.approximants.nodal.contract import Evaluator


def ring(mesh: SimplexMesh, k: int, nodes: slice) -> sparse.csr_array:
    """Return a sparse matrix, shape (number of nodes, number of cells), with a nonzero entry where a cell belongs to the
    k-th ring of a node. The first ring is the cells that contain the node, the next one the cells that contain a node of
    the previous ring.

    nodes: slice of the node numbers, whose nodes are the rows.
    """
    cells = mesh.incidence[nodes]
    for _ in range(k - 1):
        cells = (cells @ mesh.incidence.T) @ mesh.incidence
        cells.data[:] = 1
    return cells


def ring_size(mesh: SimplexMesh, cells: sparse.csr_array, nodes: slice) -> np.ndarray:
    """Return the largest distance from each node of a slice of the node numbers to a vertex of its ring (the cells around
    it, see `ring`) [m], shape (number of nodes,).

    cells: matrix of `ring` for these nodes.
    """
    vertices = sparse.csr_array(cells @ mesh.incidence.T)
    row = np.repeat(np.arange(vertices.shape[0]), np.diff(vertices.indptr))
    distance = np.linalg.norm(mesh.nodes[nodes][row] - mesh.nodes[vertices.indices], axis=1)
    size = np.zeros(vertices.shape[0])
    np.maximum.at(size, row, distance)
    return size


def nodes_of_cells(mesh: SimplexMesh, k: int) -> Lists:
    """Return for each cell, in ascending order, its active nodes: the nodes whose k-th ring (the cells around a node, see
    `ring`) contains the cell."""
    nodes = sparse.csr_array(mesh.incidence.T)
    for _ in range(k - 1):
        nodes = sparse.csr_array(nodes @ mesh.neighbours)
    nodes.sort_indices()
    return Lists(nodes.indptr.astype(np.int64), nodes.indices.astype(np.int64))


def ring_boundaries(mesh: SimplexMesh, k: int) -> tuple[Lists, np.ndarray]:
    """Return for each node the faces that bound its k-th ring (the cells around it, see `ring`), except faces on the
    boundary of the mesh, and the largest distance from the node to a vertex of the ring [m], shape (n,)."""
    faces, owners = mesh.faces
    inner = np.flatnonzero(owners[:, 1] >= 0)
    ones = np.ones(2 * len(inner), np.int32), (owners[inner].T.ravel(), np.tile(inner, 2))
    sides = sparse.csr_array(ones, shape=(len(mesh.cells), len(faces)))
    first, items, sizes = [np.zeros(1, np.int64)], [], []
    for start in range(0, len(mesh.nodes), BLOCK):
        nodes = slice(start, start + BLOCK)
        cells = ring(mesh, k, nodes)
        sizes.append(ring_size(mesh, cells, nodes))
        counts = sparse.csr_array(cells @ sides)
        counts.data = (counts.data == 1).astype(np.int32)  # a face with both cells in the ring lies within it
        counts.eliminate_zeros()
        counts.sort_indices()
        first.append(first[-1][-1] + counts.indptr[1:].astype(np.int64))
        items.append(counts.indices.astype(np.int64))
    return Lists(np.concatenate(first), np.concatenate(items)), np.concatenate(sizes)


def with_faces(evaluator: "Evaluator", mesh: SimplexMesh, nodes: np.ndarray, faces: np.ndarray) -> "Evaluator":
    """Return an evaluator with an additional face for each given node, on which its shape function vanishes.

    evaluator: evaluator whose parameters include `distances`; nodes, faces: numbers of the nodes and of the corresponding
    faces of the mesh, shape (k,) each.
    """
    distances = evaluator.functions.distances
    n, f = len(mesh.nodes), len(mesh.faces[0])
    known = np.repeat(np.arange(n), np.diff(distances.first)) * f + distances.faces
    keys = np.unique(np.concatenate([known, nodes * f + faces]))
    distances = distances._replace(first=np.searchsorted(keys, np.arange(n + 1) * f), faces=keys % f)
    return evaluator._replace(functions=evaluator.functions._replace(distances=distances))


def nodes_in_reach(mesh: SimplexMesh, reach: np.ndarray) -> Lists:
    """Return for each cell, in ascending order, the nodes whose spherical supports may overlap the cell; reach: radii of
    the supports [m], shape (n,)."""
    middle = mesh.nodes[mesh.cells].mean(axis=1)
    radius = np.linalg.norm(mesh.nodes[mesh.cells] - middle[:, None], axis=2).max(axis=1)
    tree = cKDTree(mesh.nodes)
    near = tree.query_ball_point(middle, radius + reach.max(), return_sorted=True)
    count = np.array([len(found) for found in near])
    items = np.concatenate([np.asarray(found, np.int64) for found in near])
    cell = np.repeat(np.arange(len(mesh.cells)), count)
    kept = np.linalg.norm(mesh.nodes[items] - middle[cell], axis=1) <= radius[cell] + reach[items]
    first = np.concatenate([[0], np.cumsum(np.bincount(cell[kept], minlength=len(mesh.cells)))])
    return Lists(first.astype(np.int64), items[kept])
