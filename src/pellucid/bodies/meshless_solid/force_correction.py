"""Essential boundary conditions by constraint forces, for shape functions that do not interpolate nodal values.

After the velocity update without constraints, impulses λ_j are distributed to the nodes with the weights s_ja, so that the
field takes the prescribed values v̄_i. With the nodal velocities v_a, masses m_a and changes of velocity Δv_a,

    Σ_j V_ij λ_j = v̄_i - Σ_a s_ia v_a,  V_ij = Σ_a s_ia s_ja/m_a,  m_a Δv_a = Σ_j s_ja λ_j .

The simplified SEBCIEM applies forces at the nodes, s_ja = p_a(x_j), and the field is exact there. EBCIEM distributes each
force over the faces around its node with linear functions N_j, s_ja = ∮ p_a N_j dS / ∮ N_j dS, so that uniform tractions
are exact (Joldes, Chowdhury, Wittek & Miller 2017, Eng. Anal. Bound. Elem. 80, 94). The published method still prescribes
the field at the nodes. V is then not symmetric, the forces do work on the error between the nodes, and undamped motion
grows. Here the mean over the faces, with the same weights, is prescribed. v̄ also corrects the error of the displacement.
"""

from collections.abc import Callable

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, SuperLU, onenormest, splu

from pellucid.approximants.nodal.contract import Evaluator
from pellucid.approximants.nodal.faces import unit_normals
from pellucid.bodies.meshless_solid.prescribed import PrescribedField, values_at
from pellucid.findings import Refusal
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.quadrature import TRIANGLE, TRIANGLE_WEIGHTS

LARGEST_CONDITION = 1e10  # of V, above which forces are mostly round-off

Solve = Callable[[np.ndarray], np.ndarray]


class ForceCorrection:
    """Computes the impulses on nodes that make the displacement field of a solid follow its prescribed values (method: see
    `pellucid.bodies.meshless_solid.force_correction`).

    prescribed: prescribed displacements; values: shape functions at all nodes, shape (n, n); evaluator: shape functions at
    any point; position: nodal positions of the body [m], shape (n, 3), read at each call; inertia: nodal masses [kg], shape
    (n,); motions: first row of the prescribed values that belongs to a motion, and the row after the last; spread: True to
    distribute forces over faces (EBCIEM). Raises Refusal if conditions on two nodes are nearly identical.
    """

    def __init__(
        self,
        prescribed: PrescribedField,
        values: sparse.csr_array,
        evaluator: Evaluator,
        position: np.ndarray,
        inertia: np.ndarray,
        motions: tuple[int, int],
        spread: bool,
    ) -> None:
        self._prescribed, self._position, self._motions = prescribed, position, motions
        self._axes: list[tuple[np.ndarray, sparse.csr_array]] = []
        known: dict[bytes, sparse.csr_array] = {}  # axes mostly have the same nodes and faces
        for axis in range(3):
            nodes, faces = np.flatnonzero(prescribed.number[:, axis]), prescribed.faces[prescribed.held[:, axis]]
            key = nodes.tobytes() + faces.tobytes()
            if key not in known:
                shares = values[nodes]
                known[key] = spread_over_faces(prescribed, evaluator, faces, nodes, shares) if spread else shares
            self._axes.append((nodes, known[key]))
        self._factor(inertia)

    def _factor(self, inertia: np.ndarray) -> None:
        self._inertia = inertia
        known = {id(shares): _solver(shares, inertia) for _, shares in self._axes}
        self._solve = [known[id(shares)] for _, shares in self._axes]

    def impulses(self, velocity: np.ndarray, inertia: np.ndarray, rows: np.ndarray, dt: float) -> tuple[np.ndarray, np.ndarray]:
        if inertia is not self._inertia:
            self._factor(inertia)
        by_node, of_rows = np.zeros((2, *velocity.shape)), np.zeros_like(rows)
        displacement = self._position - self._prescribed.mesh.nodes
        for axis, (nodes, shares) in enumerate(self._axes):
            row = self._prescribed.number[nodes, axis] - 1
            behind = self._prescribed.displacement[row, axis] - shares @ displacement[:, axis]
            impulse = self._solve[axis](rows[row, axis] + behind / dt - shares @ velocity[:, axis])
            of_motion = (row >= self._motions[0]) & (row < self._motions[1])
            for cause, given in enumerate((impulse * ~of_motion, impulse * of_motion)):
                by_node[cause, :, axis] = shares.T @ given
            # shares add up to one but for rounding
            np.add.at(of_rows[:, axis], row, np.asarray(shares.sum(axis=1)) * impulse)
        return by_node, of_rows


def spread_over_faces(
    prescribed: PrescribedField, evaluator: Evaluator, chosen: np.ndarray, nodes: np.ndarray, values: sparse.csr_array
) -> sparse.csr_array:
    """Return the weights with which the impulse at each of m prescribed nodes is distributed to all n nodes, shape (m, n):
    the means of the shape functions over the boundary faces around the prescribed node, weighted with its linear function
    on the faces (EBCIEM).

    prescribed: prescribed displacements, with the mesh; evaluator: shape functions at any point; chosen: numbers of the
    boundary faces; nodes: the prescribed nodes, shape (m,); values: shape functions at the prescribed nodes, shape (m, n).
    A prescribed node that belongs to none of the faces `chosen` has a point force at its position, with the weights
    `values`.
    """
    mesh = prescribed.mesh
    faces, owners = mesh.faces
    corners, n = mesh.nodes[faces[chosen]], len(TRIANGLE)
    area = np.linalg.norm(vector_areas(mesh.nodes, faces[chosen]), axis=1)
    normals = np.repeat(unit_normals(mesh.nodes, faces[chosen]), n, axis=0)
    places = np.einsum("qk,fki->fqi", TRIANGLE, corners).reshape(-1, 3)
    functions = values_at(mesh, evaluator, np.repeat(owners[chosen, 0], n), places, normals)
    weights = np.einsum("f,q,qk->fqk", area, TRIANGLE_WEIGHTS, TRIANGLE).ravel()
    row = np.repeat(np.searchsorted(nodes, faces[chosen]), n, axis=0).ravel()
    column = np.repeat(np.arange(n * len(chosen)), 3)
    linear = sparse.csr_array((weights, (row, column)), shape=(len(nodes), n * len(chosen)))
    about = np.asarray(linear.sum(axis=1))
    alone = about == 0.0
    scaled = sparse.diags_array(1.0 / np.where(alone, 1.0, about)) @ (linear @ functions)
    return sparse.csr_array(scaled + sparse.diags_array(alone.astype(float)) @ values)


def _solver(shares: sparse.csr_array, inertia: np.ndarray) -> Solve:
    """Return a function that computes the impulses at m prescribed nodes [N s] from the errors of the velocity field there
    [m/s], shape (m,) both.

    shares: weights with which each of these impulses is distributed to the n nodes, shape (m, n); inertia: nodal masses [kg],
    shape (n,).
    """
    if shares.shape[0] == 0:
        return np.copy
    V = sparse.csc_array(shares @ sparse.diags_array(1.0 / inertia) @ shares.T)
    try:
        factors = splu(V, options={"SymmetricMode": True}, permc_spec="MMD_AT_PLUS_A")
    except RuntimeError:  # an exact zero on the diagonal
        raise _dependent(np.inf) from None
    condition = _condition(V, factors)
    if not condition < LARGEST_CONDITION:
        raise _dependent(condition)
    return lambda lacking: np.asarray(factors.solve(lacking))


def _dependent(condition: float) -> Refusal:
    text = "forces on the prescribed nodes cannot be computed: their effects are nearly dependent, with a condition number of"
    remedy = 'prescribe only nodes of the surface, or use maximum entropy or linear functions with "direct"'
    return Refusal(f"{text} {condition:.2g}, above {LARGEST_CONDITION:.0g}", remedy)


def _condition(V: sparse.csc_array, factors: SuperLU) -> float:
    """Estimate the condition number, in the 1-norm, of the symmetric matrix V that maps impulses at prescribed nodes to
    velocity changes there, from its LU factors.
    """

    def solve(right: np.ndarray) -> np.ndarray:
        return np.asarray(factors.solve(right))

    inverse = LinearOperator(V.shape, solve, rmatvec=solve, matmat=solve, rmatmat=solve)
    return float(abs(V).sum(axis=0).max() * onenormest(inverse))
