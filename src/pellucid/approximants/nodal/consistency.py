"""Gradients corrected so that their quadrature is consistent: the patch test is passed to round-off.

With shape functions p_a and their gradients at the quadrature points q of weights w_q, the divergence theorem fails by
e_a = ∮ p_a n dS - Σ_q w_q ∇p_a(q). The correction δ_aq = p_a(q) (η_a - [1, x_a] β_q), where β_q is the fit of η by an affine
function at q with the weights p_a(q), changes neither partition of unity nor linear reproduction, and Σ_q w_q δ_aq = e_a
is one symmetric system for η, semidefinite with the affine functions in its null space. It is the correction of least
Σ_q w_q |δ_aq|²/p_a(q); functions that may be negative have |p_a(q)| in place of p_a(q) here. (Chen, Hillman & Rüter 2013,
Int. J. Numer. Methods Eng. 95, 387, state the condition.)
"""

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import splu

from pellucid.approximants.nodal.contract import Evaluator
from pellucid.approximants.nodal.faces import face_shares
from pellucid.approximants.nodal.table import Rows
from pellucid.geometry.cells import outer_faces_of_cells, vector_areas
from pellucid.geometry.simplex_mesh import SimplexMesh


def boundary_integrals(mesh: SimplexMesh, evaluator: Evaluator) -> np.ndarray:
    """∮ p_a n dS over the boundary of a mesh of tetrahedra [m²], shape (n, 3)."""
    faces, cells = outer_faces_of_cells(mesh.cells)
    shares = face_shares(evaluator, mesh.nodes, faces, cells)
    return shares.at_nodes(vector_areas(mesh.nodes, faces), len(mesh.nodes))


def correct(mesh: SimplexMesh, evaluator: Evaluator, rows: Rows, points: np.ndarray, weights: np.ndarray) -> None:
    """Correct the gradients of rows at quadrature points [m], shape (m, 3), with weights [m³], shape (m,), in place."""
    n, count = len(mesh.nodes), np.diff(rows.row)
    point = np.repeat(np.arange(len(points)), count)
    row_start = np.repeat(3 * rows.row[:-1] - rows.row[:-1], count) + np.arange(len(point))
    error = boundary_integrals(mesh, evaluator)
    components = [row_start + axis * np.repeat(count, count) for axis in range(3)]
    for axis, places in enumerate(components):
        error[:, axis] -= np.bincount(rows.nodes, weights[point] * rows.gradients[places], n)
    share = abs(rows.values)
    linear = np.column_stack([np.ones(len(point)), mesh.nodes[rows.nodes] - points[point]])
    moment = np.zeros((len(points), 4, 4))
    for i in range(4):
        for j in range(4):
            moment[:, i, j] = np.bincount(point, share * linear[:, i] * linear[:, j], len(points))
    # the affine functions, orthonormal with the weights |p_a|, times these
    half = np.linalg.inv(np.linalg.cholesky(moment))
    affine = np.stack([share * np.einsum("mi,mi->m", half[point, i], linear) for i in range(4)])
    root = np.sqrt(weights)[point]
    entries = sparse.csr_array((np.concatenate(root * affine), _stacked(rows, 4)), shape=(4 * len(points), n))
    system = sparse.diags_array(np.bincount(rows.nodes, weights[point] * share, n)) - entries.T @ entries
    eta = _solve(sparse.csc_array(system), error, mesh.nodes)
    for axis, places in enumerate(components):
        correction = share * eta[rows.nodes, axis]
        for part in affine:
            correction -= part * np.bincount(point, part * eta[rows.nodes, axis], len(points))[point]
        rows.gradients[places] += correction


def _stacked(rows: Rows, parts: int) -> tuple[np.ndarray, np.ndarray]:
    point = np.repeat(np.arange(len(rows.row) - 1), np.diff(rows.row))
    n = len(rows.row) - 1
    return np.concatenate([part * n + point for part in range(parts)]), np.tile(rows.nodes, parts)


def _solve(system: sparse.csc_array, error: np.ndarray, nodes: np.ndarray) -> np.ndarray:
    """η of a system whose null space are the affine functions: four nodes that are not coplanar are pinned."""
    pinned = _far_apart(nodes)
    free = np.setdiff1d(np.arange(len(nodes)), pinned)
    eta = np.zeros_like(error)
    eta[free] = splu(system[free][:, free].tocsc(), options={"SymmetricMode": True}, permc_spec="MMD_AT_PLUS_A").solve(
        error[free]
    )
    return eta


def _far_apart(nodes: np.ndarray) -> np.ndarray:
    """Four nodes that span a large tetrahedron."""
    centred = nodes - nodes.mean(axis=0)
    chosen = [int(np.argmax(np.linalg.norm(centred, axis=1)))]
    rest = nodes - nodes[chosen[0]]
    for _ in range(3):
        length = np.linalg.norm(rest, axis=1)
        chosen.append(int(np.argmax(length)))
        direction = rest[chosen[-1]] / length[chosen[-1]]
        rest = rest - np.outer(rest @ direction, direction)
    return np.array(chosen)
