"""Shape functions over faces of the cells."""

import numpy as np

from pellucid.approximants.nodal.contract import Evaluator
from pellucid.approximants.nodal.table import evaluate
from pellucid.geometry.algorithms.quadrature import TRIANGLE, TRIANGLE_WEIGHTS
from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.face_shares import FaceShares

SMALLEST = 1e-16  # share that is kept: functions of nodes off a face vanish on it but for rounding


def unit_normals(nodes: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Of triangles between nodes [m], shape (f, 3), to either side: shape (f, 3)."""
    areas = vector_areas(nodes, faces)
    return np.asarray(areas / np.linalg.norm(areas, axis=1)[:, None])


def face_shares(evaluator: Evaluator, nodes: np.ndarray, faces: np.ndarray, cells: np.ndarray) -> FaceShares:
    """Means of the shape functions over triangles between nodes [m], shape (f, 3), faces of cells, shape (f,): ∫ p_a dA / A.

    They reproduce constant and linear fields: on each face, Σ_a of the shares is 1, and Σ_a of shares times nodes its middle.
    """
    means, normals = np.zeros(0), unit_normals(nodes, faces)
    for place, weight in zip(TRIANGLE, TRIANGLE_WEIGHTS, strict=True):
        rows = evaluate(evaluator, cells, np.einsum("k,fki->fi", place, nodes[faces]), False, normals)
        means = weight * rows.values + (means if len(means) else 0.0)
    kept = abs(means) > SMALLEST
    return FaceShares(np.repeat(np.arange(len(faces)), np.diff(rows.row))[kept], rows.nodes[kept], means[kept])
