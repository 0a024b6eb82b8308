"""Which nodes the elements of a membrane have, and which elements its nodes."""

from typing import NamedTuple

import numpy as np

from pellucid.geometry.meshes.surface_mesh import Mesh


class Fan(NamedTuple):
    """The corners about each node: places[start[K]:start[K+1]] for node number K, as k e + corner of element e of k."""

    start: np.ndarray  # (n+1,)
    places: np.ndarray


def fan_of(corners: np.ndarray, n: int, owned: np.ndarray | None = None) -> Fan:
    """The corners about each of n nodes, of elements with these, shape (m, k); where `owned`, shape (m, k), says so."""
    places = np.arange(corners.size) if owned is None else np.flatnonzero(owned)
    nodes = corners.ravel()[places]
    order = np.argsort(nodes, kind="stable")
    return Fan(np.searchsorted(nodes[order], np.arange(n + 1)), places[order])


class ElementMesh:
    """Quadrilaterals, then triangles. corners, shape (m, 4): their nodes, of triangles the last one twice."""

    def __init__(self, mesh: Mesh) -> None:
        self.n_nodes, self.n_quads = len(mesh.vertices), len(mesh.quads)
        triangles = mesh.triangles[:, [0, 1, 2, 2]]
        self.corners = np.ascontiguousarray(np.concatenate([mesh.quads, triangles]).astype(np.int64))
        self.sides = np.where(np.arange(len(self.corners)) < self.n_quads, 4, 3)
        self._owned = np.arange(4) < self.sides[:, None]  # whether a corner counts
        self.fan = fan_of(self.corners, self.n_nodes, self._owned)

    def areas(self, position: np.ndarray) -> np.ndarray:
        """Areas of the elements [m²], shape (m,), for nodes at these positions [m], shape (n, 3), in the order of the mesh."""
        a, b, c, d = (position[corner] for corner in self.corners.T)
        quad = np.arange(len(self.corners)) < self.n_quads
        other = np.where(quad[:, None], d - b, c - b)
        return np.asarray(0.5 * np.linalg.norm(np.cross(c - a, other), axis=1))

    def at_nodes(self, values: np.ndarray) -> np.ndarray:
        """Equal shares of what each element has, shape (m, ...), summed at its nodes, shape (n, ...)."""
        columns = values.reshape(len(values), -1) / self.sides[:, None]
        nodes = self.corners[self._owned]
        sums = [np.bincount(nodes, np.repeat(column, self.sides), minlength=self.n_nodes) for column in columns.T]
        return np.stack(sums, axis=1).reshape(self.n_nodes, *values.shape[1:])


def rest_gradients(places: np.ndarray) -> np.ndarray:
    """Gradients of the second and the third shape function of triangles, in axes of their planes [1/m], shape (t, 4).

    places: of their corners at rest [m], shape (t, 3, 3). The first axis is along the first edge.
    """
    chi, psi = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    length = np.linalg.norm(chi, axis=1)
    along = np.einsum("ti,ti->t", chi, psi) / length
    height = np.linalg.norm(np.cross(chi, psi), axis=1) / length
    return np.stack([1.0 / length, -along / (length * height), np.zeros(len(chi)), 1.0 / height], axis=1)
