"""Prescribed displacements of a meshless solid, and the difference between its displacement field and these values."""

import numpy as np
from scipy import sparse

from pellucid.approximants.nodal.contract import Evaluator
from pellucid.approximants.nodal.faces import unit_normals
from pellucid.approximants.nodal.table import NO_NORMALS, evaluate
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
