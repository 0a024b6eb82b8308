"""Prescribed displacements of a meshless solid: the difference between its displacement field and these values, and
constraint forces that enforce them if the shape functions do not interpolate nodal values."""

from collections.abc import Callable

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import LinearOperator, SuperLU, onenormest, splu

from pellucid.approximants.nodal.contract import Evaluator
from pellucid.approximants.nodal.table import NO_NORMALS, evaluate, unit_normals
from pellucid.findings import Refusal
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.quadrature import TRIANGLE, TRIANGLE_WEIGHTS
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh

REACHES = 1e-11  # value above which a function counts as one that does not vanish; on faces it is found to 1e-12
# shares of a face's corners at places between them: the middle, and towards the corners and edges. Not on edges: where these
# are on the convex hull, maximum entropy has two nodes and no finite λ
_ON_FACE = np.array(
    [np.full(3, 1 / 3), *(np.full((3, 3), 0.15) + 0.55 * np.eye(3)), *(np.full((3, 3), 0.45) - 0.35 * np.eye(3))]
)


class PrescribedField:
    """The nodes of a meshless solid with a prescribed displacement, and the boundary faces on which the displacement field
    is prescribed.

    number, shape (n, 3): along each axis 0 if a node is free, else 1 + the row of its support or motion; group, shape (n,
    3): one number for all supports and motions that always prescribe the same displacement, 0 if the node is free; n_rows:
    number of supports and motions. Attributes: displacement: displacement prescribed so far by each support or motion [m],
    shape (n_rows, 3); faces: numbers of the boundary faces whose three nodes belong to one group along at least one axis;
    held, shape (faces, 3): True for the axes along which the nodes of the face belong to one group.
    """

    def __init__(self, mesh: SimplexMesh, number: np.ndarray, group: np.ndarray, n_rows: int) -> None:
        self.mesh, self.number, self._group = mesh, number, group
        self.displacement = np.zeros((n_rows, 3))
        self.nodes = np.flatnonzero((number > 0).any(axis=1))
        boundary = mesh.boundary
        corners = group[mesh.faces[0][boundary]]
        held = (corners > 0).all(axis=1) & (corners == corners[:, :1]).all(axis=1)
        some = held.any(axis=1)
        self.faces, self.held = boundary[some], held[some]

    def disturbing(self, evaluator: Evaluator) -> tuple[np.ndarray, np.ndarray]:
        """Return pairs of a node and a prescribed face, shape (k,) each, on which the node's shape function disturbs the
        prescribed displacement because the node belongs to another group (another prescribed displacement, or none).

        If one such function does not vanish on a face, the result contains the pairs of this face with all other active nodes
        of other groups. evaluator: shape functions at any point.
        """
        if not len(self.faces):
            return self.faces, self.faces
        rows = self._on_faces(evaluator)
        face = np.repeat(np.repeat(np.arange(len(self.faces)), len(_ON_FACE)), np.diff(rows.indptr))
        reaches = (abs(rows.data) > REACHES) & self._apart(face, rows.indices)
        disturbed = np.flatnonzero(np.bincount(face[reaches], minlength=len(self.faces)))
        first, node = evaluator.active.of(self.mesh.faces[1][self.faces[disturbed], 0])
        face = np.repeat(disturbed, np.diff(first))
        apart = self._apart(face, node)
        return node[apart], self.faces[face[apart]]

    def _apart(self, face: np.ndarray, node: np.ndarray) -> np.ndarray:
        """Return a mask of k pairs of face and node, shape (k,): True if the node has another prescribed displacement than the
        face, or none, along an axis along which the face has one. face: indices among the prescribed faces, shape (k,); node:
        numbers of the nodes, shape (k,).
        """
        corner = self.mesh.faces[0][self.faces[face], 0]
        return np.asarray(((self._group[node] != self._group[corner]) & self.held[face]).any(axis=1))

    def lone(self, values: sparse.csr_array) -> tuple[np.ndarray, np.ndarray]:
        """Find the boundary nodes that are prescribed along an axis but belong to no face whose nodes all have the same
        prescribed displacement along this axis. Returns their numbers, shape (k,), and how much other displacements contribute
        to the field there, shape (k,): the sum of the values, at the node, of the shape functions of nodes with another
        prescribed displacement or none; the largest of the three axes.

        values: shape functions at all nodes, shape (n, n).
        """
        outer = np.zeros(self.number.shape, bool)
        outer[self.mesh.faces[0][self.mesh.boundary].ravel()] = True
        alone = outer & (self.number > 0)
        for axis in range(3):
            alone[self.mesh.faces[0][self.faces[self.held[:, axis]]].ravel(), axis] = False
        nodes = np.flatnonzero(alone.any(axis=1))
        rows = values[nodes].tocoo()
        missed = np.zeros(len(nodes))
        for axis in range(3):
            like = self._group[rows.col, axis] == self._group[nodes[rows.row], axis]
            followed = np.bincount(rows.row, rows.data * like, len(nodes))
            missed = np.maximum(missed, np.where(alone[nodes, axis], abs(1.0 - followed), 0.0))
        return nodes, missed

    def residuals(self, values: sparse.csr_array, evaluator: Evaluator) -> "Residuals":
        """Build the object that evaluates the differences between the displacement field and its prescribed values. values:
        shape functions at all nodes, shape (n, n); evaluator: shape functions at any point.
        """
        on_boundary = np.intersect1d(self.nodes, self.mesh.faces[0][self.mesh.boundary])
        first = self.mesh.faces[0][self.faces][:, 0]
        n = len(_ON_FACE)
        held = np.repeat(self.held, n, axis=0)
        between = np.where(held, np.repeat(self.number[first], n, axis=0), 0)
        return Residuals(self, (values[on_boundary], self.number[on_boundary]), (self._on_faces(evaluator), between))

    def at(self, number: np.ndarray) -> np.ndarray:
        """Return the displacements prescribed so far [m], shape (m, 3). number: 0 for a free component, else 1 + the row of
        its support or motion, shape (m, 3).
        """
        rows = np.concatenate([np.zeros((1, 3)), self.displacement])
        return np.asarray(np.take_along_axis(rows, number, axis=0))

    def _on_faces(self, evaluator: Evaluator) -> sparse.csr_array:
        """Return the values of the shape functions of all n nodes at a fixed set of points (`_ON_FACE`) in each prescribed
        face, face by face, one row for each point. evaluator: shape functions at any point.
        """
        faces, owners = self.mesh.faces
        places = np.einsum("qk,fki->fqi", _ON_FACE, self.mesh.nodes[faces[self.faces]]).reshape(-1, 3)
        n, normals = len(_ON_FACE), unit_normals(self.mesh.nodes, faces[self.faces])
        return values_at(self.mesh, evaluator, np.repeat(owners[self.faces, 0], n), places, np.repeat(normals, n, axis=0))


class Residuals:
    """Evaluates the distances between the displacement field Σ_a p_a(x) u_a, with shape functions p_a and nodal coefficients
    u_a, and the prescribed displacement along the prescribed axes, at boundary nodes and at points on faces between them.
    """

    def __init__(
        self,
        prescribed: PrescribedField,
        at_nodes: tuple[sparse.csr_array, np.ndarray],
        between: tuple[sparse.csr_array, np.ndarray],
    ) -> None:
        """prescribed: prescribed displacements; at_nodes, between: shape functions at m boundary nodes or points between them,
        shape (m, n), and the numbers of the constraints there (see `PrescribedField`), shape (m, 3).
        """
        self._prescribed, self._sets = prescribed, {"nodes": at_nodes, "between": between}

    def largest(self, displacement: np.ndarray) -> dict[str, float]:
        """Return the largest difference between the displacement field and its prescribed values [m], at boundary nodes
        ("nodes") and at points between them ("between"). A set without points has no entry. displacement: of the nodes [m],
        shape (n, 3).
        """
        found = {}
        for name, (values, number) in self._sets.items():
            if len(number):
                error = np.where(number > 0, values @ displacement - self._prescribed.at(number), 0.0)
                found[name] = float(np.linalg.norm(error, axis=1).max())
        return found


def values_at(
    mesh: SimplexMesh, evaluator: Evaluator, cells: np.ndarray, places: np.ndarray, normals: np.ndarray = NO_NORMALS
) -> sparse.csr_array:
    """Return the values of the shape functions at positions [m], shape (m, 3), as a matrix of shape (m, n).

    evaluator: shape functions at any point; cells: cell that contains each position, shape (m,); normals: normals of the faces
    that contain the positions, shape (m, 3), if they are on faces.
    """
    rows = evaluate(evaluator, cells, places, False, normals)
    return sparse.csr_array((rows.values, rows.nodes, rows.row), shape=(len(cells), len(mesh.nodes)))


def values_at_nodes(mesh: SimplexMesh, evaluator: Evaluator) -> sparse.csr_array:
    """Return the values of the shape functions of all n nodes at the nodes, shape (n, n), one row for each position. evaluator:
    shape functions at any point.
    """
    cells = np.zeros(len(mesh.nodes), np.int64)
    corners = mesh.cells.shape[1]
    cells[mesh.cells.ravel()] = np.repeat(np.arange(len(mesh.cells)), corners)
    return values_at(mesh, evaluator, cells, mesh.nodes)


LARGEST_CONDITION = 1e10  # of V, above which forces are mostly round-off

Solve = Callable[[np.ndarray], np.ndarray]


class ForceCorrection:
    """Computes the impulses on nodes that make the displacement field of a solid follow its prescribed values .

    prescribed: prescribed displacements; values: shape functions at all nodes, shape (n, n); evaluator: shape functions at
    any point; position: nodal positions of the body [m], shape (n, 3), read at each call; inertia: nodal masses [kg], shape
    (n,); motions: first row of the prescribed values that belongs to a motion, and the row after the last; spread: True to
    distribute forces over faces (EBCIEM). Raises Refusal if conditions on two nodes are nearly identical.

    After the velocity update without constraints, impulses λ_j are distributed to the nodes with the weights s_ja, so that the
    field takes the prescribed values v̄_i. With the nodal velocities v_a, masses m_a and changes of velocity Δv_a,

        Σ_j V_ij λ_j = v̄_i - Σ_a s_ia v_a,  V_ij = Σ_a s_ia s_ja/m_a,  m_a Δv_a = Σ_j s_ja λ_j .

    The simplified SEBCIEM applies forces at the nodes, s_ja = p_a(x_j), and the field is exact there. EBCIEM distributes each
    force over the faces around its node with linear functions N_j, s_ja = ∮ p_a N_j dS / ∮ N_j dS, so that uniform tractions
    are exact (Joldes, Chowdhury, Wittek & Miller 2017, Eng. Anal. Bound. Elem. 80, 94). The published method still prescribes
    the field at the nodes. V is then not symmetric, the forces do work on the error between the nodes, and undamped motion
    grows. Here the mean over the faces, with the same weights, is prescribed. v̄ also corrects the error of the displacement.
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
