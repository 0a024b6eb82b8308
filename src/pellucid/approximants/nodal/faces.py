"""Integrals of shape functions over faces of the cells."""

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator
from pellucid.approximants.nodal.table import evaluate
from pellucid.geometry.meshes.cells import FaceShares, vector_areas
from pellucid.geometry.meshes.quadrature import TRIANGLE, TRIANGLE_WEIGHTS

SMALLEST = 1e-16  # smaller values are dropped: functions of nodes off a face vanish on it up to rounding


def unit_normals(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return unit normals of triangles, shape (f, 3); their sign is arbitrary.

    nodes: positions, shape (n, 3) [m]; faces: node numbers of the corners, shape (f, 3).
    """
    areas = vector_areas(nodes, faces)
    return np.asarray(areas / np.linalg.norm(areas, axis=1)[:, None])


def face_shares(evaluator: Evaluator, nodes: np.ndarray, faces: np.ndarray, cells: np.ndarray) -> FaceShares:
    """Return the means ∫ p_a dA / A of the shape functions p_a over triangles of area A, with the numbers a of the nodes.

    evaluator: defines the shape functions; nodes: positions, shape (n, 3) [m]; faces: corners of the triangles, shape (f,
    3); cells: number of the cell that contains each face, shape (f,). The means reproduce constant and linear fields: on
    each face the sum of the means is 1, and the sum of means times nodal positions is the centroid of the face.
    """
    means, normals = np.zeros(0), unit_normals(nodes, faces)
    for place, weight in zip(TRIANGLE, TRIANGLE_WEIGHTS, strict=True):
        rows = evaluate(evaluator, cells, np.einsum("k,fki->fi", place, nodes[faces]), False, normals)
        means = weight * rows.values + (means if len(means) else 0.0)
    kept = abs(means) > SMALLEST
    return FaceShares(np.repeat(np.arange(len(faces)), np.diff(rows.row))[kept], rows.nodes[kept], means[kept])
