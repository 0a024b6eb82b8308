"""Contact points on the outer faces of a meshless solid, and their effective masses."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from scipy import sparse

from pellucid.approximants.nodal.contract import Evaluator
from pellucid.bodies.meshless_solid.prescribed import values_at
from pellucid.geometry.meshes.cells import cells_of_faces, outer_faces
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh

SMALLEST = 1e-12  # smallest weight that is kept: functions of nodes off a face vanish on it, except for round-off


class SkinPoints(NamedTuple):
    """m contact points on the surface of a solid: its nodes and, on faces longer than a limit, points of a lattice.

    The mass of a point is its effective mass in contact, a share of the masses of the nodes that move it. For each node a, Σ_k
    S_ka m_k ≤ m_a, so that contact adds no energy.
    """

    values: sparse.csr_array  # (m, n) weights S_ka = p_a(x_k) of the nodes a at the points k
    mass: np.ndarray  # (m,) effective masses [kg]
    is_node: np.ndarray  # (m,) True for a node of the mesh
    faces: np.ndarray  # (f, 3) points at the corners of the outer faces
    triangles: np.ndarray  # (t, 3) points at the corners of the triangles into which the faces are divided


def skin_points(
    mesh: SimplexMesh, evaluator: Evaluator, mass: np.ndarray, longest: float, closed: Sequence[np.ndarray] = ()
) -> SkinPoints:
    """Return contact points at most `longest` [m] apart on the outer faces of a mesh with nodal masses [kg], shape (n,).

    evaluator: shape functions at any point; closed: masks, shape (n,), of sets of nodes that stay on a wall; faces with all
    nodes in one set have no contact.
    """
    faces = outer_faces(mesh.cells)
    behind = [on_wall[faces].all(axis=1) for on_wall in closed]
    faces = faces[~np.any(behind, axis=0)] if behind and not np.any(behind, axis=0).all() else faces
    owner = cells_of_faces(mesh.cells, faces)
    corners = mesh.nodes[faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    parts = np.maximum(1, np.ceil(edges / longest * (1.0 - 1e-9)).astype(np.int64))
    at_nodes, cell_of_node = np.zeros(len(mesh.nodes)), np.zeros(len(mesh.nodes), np.int64)
    np.maximum.at(cell_of_node, faces.ravel(), np.repeat(owner, 3))
    nodes, by_corner = np.unique(faces, return_inverse=True)
    by_corner = by_corner.reshape(-1, 3)
    places, cells, areas, triangles, count = [], [], [], [], len(nodes)
    for n in np.unique(parts):
        here = parts == n
        numbers = []
        lattice, within = _lattice(int(n))
        for shares, weight in lattice:
            corner = np.flatnonzero(shares == 1.0)
            if len(corner):
                np.add.at(at_nodes, faces[here, corner[0]], weight * area[here])
                numbers.append(by_corner[here, corner[0]])
            else:
                places.append(np.einsum("k,fki->fi", shares, corners[here]))
                cells.append(owner[here])
                areas.append(weight * area[here])
                numbers.append(count + np.arange(here.sum()))
                count += int(here.sum())
        triangles.append(np.array(numbers)[within].transpose(2, 0, 1).reshape(-1, 3))
    values = values_at(
        mesh, evaluator, np.concatenate([cell_of_node[nodes], *cells]), np.concatenate([mesh.nodes[nodes], *places])
    )
    values.data[abs(values.data) < SMALLEST] = 0.0
    values.eliminate_zeros()
    share = np.concatenate([at_nodes[nodes], *areas])
    mass_of_points = share * _least_depth(values, share, mass)
    return SkinPoints(values, mass_of_points, np.arange(len(share)) < len(nodes), by_corner, np.concatenate(triangles))


def _lattice(n: int) -> tuple[list[tuple[np.ndarray, float]], np.ndarray]:
    """Return the points of a triangle divided into n² equal triangles, as pairs of barycentric coordinates and fraction of
    the area; and the corners of the equal triangles, shape (n², 3)."""
    found: list[tuple[np.ndarray, float]] = []
    number: dict[tuple[int, int], int] = {}
    for i in range(n + 1):
        for j in range(n + 1 - i):
            shares = np.array([i, j, n - i - j]) / n
            about = {3: 6, 2: 3, 1: 1}[int((shares > 0.0).sum())]  # of the small triangles
            number[i, j] = len(found)
            found.append((shares, about / (3.0 * n * n)))
    upright = [((i + 1, j), (i, j + 1), (i, j)) for i, j in number if i + j < n]
    turned = [((i, j), (i - 1, j), (i, j - 1)) for i, j in number if i and j]
    return found, np.array([[number[corner] for corner in triangle] for triangle in upright + turned])


def _least_depth(values: sparse.csr_array, share: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Return the effective mass per area of each contact point [kg/m²], shape (m,): the smallest value of m_a / Σ_k S_ka A_k
    among the nodes a that move it.

    values: weights S_ka of the n nodes in the m points, shape (m, n); share: areas A_k of the points [m²]; mass: nodal masses
    m_a [kg], shape (n,).
    """
    of_node = values.T @ share
    depth = np.where(of_node > 0.0, mass / np.where(of_node > 0.0, of_node, 1.0), np.inf)
    return np.minimum.reduceat(depth[values.indices], values.indptr[:-1])
