"""Connectivity of the elements and hinges of a membrane."""

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pellucid.bodies.membrane_elements.geometry import frame_of
from pellucid.geometry.meshes.surface_mesh import Mesh
from pellucid.geometry.meshes.triangulation import axes_along, directed_edges, pair_edges

if TYPE_CHECKING:
    from scipy.sparse import csr_array


class Fan(NamedTuple):
    """Lists, for each node K, the element corners at the node: the entries `places[start[K]:start[K + 1]]`, each k e + c
    for corner c of element e, where elements have k corners."""

    start: np.ndarray  # (n+1,) index in `places` of the first corner of each node
    places: np.ndarray  # corners around the nodes, node by node


def fan_of(corners: np.ndarray, n: int, owned: np.ndarray | None = None) -> Fan:
    """Return the list of element corners around each of n nodes. corners: nodes of the elements, shape (m, k); owned: mask of
    the corners to include, shape (m, k); None for all.
    """
    places = np.arange(corners.size) if owned is None else np.flatnonzero(owned)
    nodes = corners.ravel()[places]
    order = np.argsort(nodes, kind="stable")
    return Fan(np.searchsorted(nodes[order], np.arange(n + 1)), places[order])


def incidence(corners: np.ndarray, n: int) -> "csr_array":
    """Return a matrix with a row per element or hinge and a column for each of n nodes, 1 at its corners. corners: nodes of the
    elements, shape (m, k)."""
    from scipy.sparse import csr_array  # slow import, not needed to read a case

    rows = np.repeat(np.arange(len(corners)), corners.shape[1])
    return csr_array((np.ones(corners.size), (rows, corners.ravel())), (len(corners), n))


def hinges_of(triangles: np.ndarray) -> np.ndarray:
    """Return for each of h hinges (edges shared by two triangles) the numbers of the two nodes of the edge, of the third
    node of the triangle on its left, and of the third node of the triangle on its right, shape (h, 4).

    triangles: shape (t, 3), with consistent orientation.
    """
    ends, across = directed_edges(triangles), triangles.T[[2, 0, 1]].ravel()
    chosen, partner = pair_edges(triangles)
    return np.column_stack([ends[chosen], across[chosen], across[partner]]).astype(np.int64)


class ElementMesh:
    """Mesh of m membrane elements: quadrilaterals first, then triangles. `corners`, shape (m, 4): nodes of the elements;
    the fourth node of a triangle repeats its third."""

    def __init__(self, mesh: Mesh) -> None:
        self.n_nodes, self.n_quads = len(mesh.vertices), len(mesh.quads)
        triangles = mesh.triangles[:, [0, 1, 2, 2]]
        self.corners = np.ascontiguousarray(np.concatenate([mesh.quads, triangles]).astype(np.int64))
        self.sides = np.where(np.arange(len(self.corners)) < self.n_quads, 4, 3)
        self._owned = np.arange(4) < self.sides[:, None]  # whether a corner counts
        self.fan = fan_of(self.corners, self.n_nodes, self._owned)

    def areas(self, position: np.ndarray) -> np.ndarray:
        """Return the areas of the elements [m²], shape (m,), for nodes at these positions [m], shape (n, 3), in mesh order."""
        a, b, c, d = (position[corner] for corner in self.corners.T)
        quad = np.arange(len(self.corners)) < self.n_quads
        other = np.where(quad[:, None], d - b, c - b)
        return np.asarray(0.5 * np.linalg.norm(np.cross(c - a, other), axis=1))

    def at_nodes(self, values: np.ndarray) -> np.ndarray:
        """Distribute element values, shape (m, ...), equally among the corners of each element, and return the sums at the
        nodes, shape (n, ...)."""
        columns = values.reshape(len(values), -1) / self.sides[:, None]
        nodes = self.corners[self._owned]
        sums = [np.bincount(nodes, np.repeat(column, self.sides), minlength=self.n_nodes) for column in columns.T]
        return np.stack(sums, axis=1).reshape(self.n_nodes, *values.shape[1:])


def rest_gradients(places: np.ndarray, direction: np.ndarray | None) -> np.ndarray:
    """Return the gradients of the second and the third shape function of triangles, in axes of their planes [1/m], shape
    (t, 4): ∂N₂/∂x₁, ∂N₂/∂x₂, ∂N₃/∂x₁, ∂N₃/∂x₂.

    places: positions of the corners of the triangles at rest [m], shape (t, 3, 3); direction: vector, shape (3,), whose
    projection onto the plane of a triangle is the first axis; None: the first axis is along the first edge.
    """
    chi, psi = places[:, 1] - places[:, 0], places[:, 2] - places[:, 0]
    if direction is not None:
        first, second = axes_along(direction, np.cross(chi, psi))
        cx, cy, px, py = (np.sum(a * b, axis=1) for a in (chi, psi) for b in (first, second))
        return np.stack([py, -px, -cy, cx], axis=1) / (cx * py - cy * px)[:, None]
    length = np.linalg.norm(chi, axis=1)
    along = np.einsum("ti,ti->t", chi, psi) / length
    height = np.linalg.norm(np.cross(chi, psi), axis=1) / length
    return np.stack([1.0 / length, -along / (length * height), np.zeros(len(chi)), 1.0 / height], axis=1)


def initial_turns(places: np.ndarray, direction: np.ndarray | None) -> np.ndarray:
    """Return the cosine and sine of the angle from the frame of each quadrilateral to its material frame, shape (q, 2).

    places: positions of the corners [m], shape (q, 4, 3); direction: vector, shape (3,), whose projection onto the plane of
    a quadrilateral is the first axis of the material frame; None: the angle is zero.
    """
    turn = np.tile((1.0, 0.0), (len(places), 1))
    if direction is None or not len(places):
        return turn
    a, b, c, d = np.moveaxis(places, 1, 0)
    frames = np.array([frame_of(tuple(chi), tuple(psi)) for chi, psi in zip(b - a + c - d, c - b + d - a, strict=True)])
    first, _ = axes_along(direction, frames[:, 2])
    turn[:, 0], turn[:, 1] = np.sum(frames[:, 0] * first, axis=1), np.sum(frames[:, 1] * first, axis=1)
    return turn
