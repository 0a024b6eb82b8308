"""Gradients corrected so that their quadrature is consistent: the patch test is passed to round-off.

With shape functions p_a and their gradients at the quadrature points q of weights w_q, the divergence theorem fails by
e_a = ∮ p_a n dS - Σ_q w_q ∇p_a(q). The correction δ_aq = p_a(q) (η_a - [1, x_a] β_q), where β_q is the fit of η by an affine
function at q with the weights p_a(q), changes neither partition of unity nor linear reproduction, and Σ_q w_q δ_aq = e_a
is one symmetric system for η, semidefinite with the affine functions in its null space. It is the correction of least
Σ_q w_q |δ_aq|²/p_a(q). (Chen, Hillman & Rüter 2013, Int. J. Numer. Methods Eng. 95, 387, state the condition.)
"""

import numpy as np

from pellucid.approximants.nodal.affine_fits import apply_correction, make_fits, quadrature_sums, system
from pellucid.approximants.nodal.contract import Evaluator
from pellucid.approximants.nodal.table import Rows, evaluate
from pellucid.approximants.nodal.two_level import solve
from pellucid.geometry.simplex_mesh import SimplexMesh

EXACT = 1e-14  # error of the divergence theorem, of the sums in it, that is round-off

# shares of the corners of a triangle, exact to degree 4 (Cowper 1973, Int. J. Numer. Methods Eng. 7, 405), and weights
_NEAR, _FAR = 0.108103018168070, 0.816847572980459
_FACE = np.array(
    [
        *(np.full((3, 3), 0.445948490915965) + (_NEAR - 0.445948490915965) * np.eye(3)),
        *(np.full((3, 3), 0.091576213509771) + (_FAR - 0.091576213509771) * np.eye(3)),
    ]
)
_FACE_WEIGHTS = np.repeat([0.223381589678011, 0.109951743655322], 3)


def boundary_integrals(mesh: SimplexMesh, evaluator: Evaluator) -> np.ndarray:
    """∮ p_a n dS over the boundary of a mesh of tetrahedra [m²], shape (n, 3)."""
    faces, owners = mesh.faces
    boundary = mesh.boundary
    corners = mesh.nodes[faces[boundary]]
    area = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inside = mesh.nodes[mesh.cells[owners[boundary, 0]]].mean(axis=1) - corners[:, 0]
    area *= -np.sign(np.einsum("fi,fi->f", area, inside))[:, None]
    total = np.zeros((len(mesh.nodes), 3))
    for share, weight in zip(_FACE, _FACE_WEIGHTS, strict=True):
        rows = evaluate(evaluator, owners[boundary, 0], np.einsum("k,fki->fi", share, corners), gradients=False)
        vector = weight * np.repeat(area, np.diff(rows.row), axis=0)
        for axis in range(3):
            total[:, axis] += np.bincount(rows.nodes, rows.values * vector[:, axis], len(mesh.nodes))
    return total


def correct(mesh: SimplexMesh, evaluator: Evaluator, rows: Rows, points: np.ndarray, weights: np.ndarray) -> None:
    """Correct the gradients of rows at quadrature points [m], shape (m, 3), with weights [m³], shape (m,), in place.

    The points of a cell stand together, as many in each. Raises ValueError where the system does not converge.
    """
    fits = make_fits(mesh.nodes, evaluator.active, rows, points, weights)
    sums, sizes = quadrature_sums(fits)
    error = boundary_integrals(mesh, evaluator) - sums
    if abs(error).max() <= EXACT * sizes.max():
        return
    matrix = system(fits)
    apply_correction(fits, solve(matrix, error, mesh.nodes))
