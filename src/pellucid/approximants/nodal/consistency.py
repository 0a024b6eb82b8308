"""Correction of gradients for consistent quadrature, so that the patch test is passed to round-off.

With shape functions p_a and their gradients at the quadrature points q with weights w_q, the error of the divergence theorem is
e_a = ∮ p_a n dS - Σ_q w_q ∇p_a(q). The correction δ_aq = p_a(q) (η_a - [1, x_a] β_q), where β_q is the fit of η by an affine
function at q with the weights p_a(q), preserves the partition of unity and linear reproduction, and Σ_q w_q δ_aq = e_a is one
symmetric system for η, semidefinite with the affine functions in its null space. It is the correction with the least Σ_q w_q
|δ_aq|²/p_a(q). For functions that may be negative, p_a(q) is replaced by |p_a(q)| here. (Chen, Hillman & Rüter 2013, Int. J.
Numer. Methods Eng. 95, 387, state the condition.)
"""

import numpy as np

from pellucid.approximants.nodal.affine_fits import apply_correction, make_fits, quadrature_sums, system
from pellucid.approximants.nodal.contract import Evaluator
from pellucid.approximants.nodal.faces import face_shares
from pellucid.approximants.nodal.table import PointRows
from pellucid.approximants.nodal.two_level import solve
from pellucid.geometry.meshes.cells import outer_faces_of_cells, vector_areas
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh

EXACT = 1e-14  # round-off error of the divergence theorem, relative to its sums, per number of spacings in the extent


def boundary_integrals(mesh: SimplexMesh, evaluator: Evaluator) -> np.ndarray:
    """Return ∮ p_a n dS over the boundary of a tetrahedral mesh for each node a, shape (n, 3) [m²].

    p_a: shape function of the node, defined by `evaluator`; n: outward unit normal.
    """
    faces, cells = outer_faces_of_cells(mesh.cells)
    shares = face_shares(evaluator, mesh.nodes, faces, cells)
    return shares.at_nodes(vector_areas(mesh.nodes, faces), len(mesh.nodes))


def correct(mesh: SimplexMesh, evaluator: Evaluator, rows: PointRows, weights: np.ndarray) -> None:
    """Correct in place the gradients of the shape functions `rows` at the quadrature points of a mesh, so that the
    quadrature satisfies the divergence theorem for each shape function, Σ_q w_q ∇p_a(q) = ∮ p_a n dS (see
    `pellucid.approximants.nodal.consistency`).

    evaluator: defines the shape functions on the boundary; weights: quadrature weights, shape (m,) [m³]. The points of a
    cell are consecutive, with the same number in each cell. Raises Refusal if the system does not converge.
    """
    fits = make_fits(mesh.nodes, evaluator.active, rows, weights)
    sums, sizes = quadrature_sums(fits)
    error = boundary_integrals(mesh, evaluator) - sums
    spacings = float(np.ptp(mesh.nodes, axis=0).max() / mesh.spacing.min())  # loss of digits in differences of coordinates
    if abs(error).max() <= EXACT * spacings * sizes.max():
        return
    matrix = system(fits)
    apply_correction(fits, solve(matrix, error, mesh.nodes))
