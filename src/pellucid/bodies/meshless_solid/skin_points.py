"""Points on the outer faces of a solid, by which others touch it."""

from typing import NamedTuple

import numpy as np
from scipy import sparse

from pellucid.approximants.nodal.contract import Evaluator
from pellucid.bodies.meshless_solid.prescribed import values_at
from pellucid.geometry.cells import cells_of_faces, outer_faces
from pellucid.geometry.simplex_mesh import SimplexMesh

SMALLEST = 1e-12  # share that is kept: functions of nodes off a face vanish on it but for rounding


class SkinPoints(NamedTuple):
    """m points of the surface: the nodes on it, and where faces are longer than asked, points on a lattice in these.

    The mass of a point is that with which it meets others, a share of the masses of the nodes that move it: of node a all
    points together have Σ_k S_ka m_k ≤ m_a, so that contact adds no energy.
    """

    values: sparse.csr_array  # (m, n) S_ka = p_a(x_k)
    mass: np.ndarray  # (m,) [kg]
    is_node: np.ndarray  # (m,) whether it is a node of the mesh


def skin_points(mesh: SimplexMesh, evaluator: Evaluator, mass: np.ndarray, longest: float) -> SkinPoints:
    """Points no further apart than `longest` [m] on the outer faces of a mesh whose nodes have masses [kg], shape (n,)."""
    faces = outer_faces(mesh.cells)
    owner = cells_of_faces(mesh.cells, faces)
    corners = mesh.nodes[faces]
    edges = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    parts = np.maximum(1, np.ceil(edges / longest * (1.0 - 1e-9)).astype(np.int64))
    at_nodes, cell_of_node = np.zeros(len(mesh.nodes)), np.zeros(len(mesh.nodes), np.int64)
    np.maximum.at(cell_of_node, faces.ravel(), np.repeat(owner, 3))
    places, cells, areas = [], [], []
    for n in np.unique(parts):
        here = parts == n
        for shares, weight in _lattice(int(n)):
            corner = np.flatnonzero(shares == 1.0)
            if len(corner):
                np.add.at(at_nodes, faces[here, corner[0]], weight * area[here])
            else:
                places.append(np.einsum("k,fki->fi", shares, corners[here]))
                cells.append(owner[here])
                areas.append(weight * area[here])
    nodes = np.unique(faces)
    values = values_at(
        mesh,
        evaluator,
        np.concatenate([cell_of_node[nodes], *cells]),
        np.concatenate([mesh.nodes[nodes], *places]),
    )
    values.data[abs(values.data) < SMALLEST] = 0.0
    values.eliminate_zeros()
    share = np.concatenate([at_nodes[nodes], *areas])
    return SkinPoints(values, share * _least_depth(values, share, mass), np.arange(len(share)) < len(nodes))


def _lattice(n: int) -> list[tuple[np.ndarray, float]]:
    """Points of a triangle that n² equal triangles divide, by the shares of its corners, and the part of its area of each."""
    found = []
    for i in range(n + 1):
        for j in range(n + 1 - i):
            shares = np.array([i, j, n - i - j]) / n
            about = {3: 6, 2: 3, 1: 1}[int((shares > 0.0).sum())]  # of the small triangles
            found.append((shares, about / (3.0 * n * n)))
    return found


def _least_depth(values: sparse.csr_array, share: np.ndarray, mass: np.ndarray) -> np.ndarray:
    """Mass over area of each point [kg/m²], the least among the nodes that move it, each of which has m_a / Σ_k S_ka A_k."""
    of_node = values.T @ share
    depth = np.where(of_node > 0.0, mass / np.where(of_node > 0.0, of_node, 1.0), np.inf)
    return np.minimum.reduceat(depth[values.indices], values.indptr[:-1])
