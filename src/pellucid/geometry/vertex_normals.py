"""Normals at the vertices of a surface of triangles."""

import numpy as np


def vertex_normals(vertices: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Unit normals at vertices [m], shape (n, 3), of a closed surface of triangles, shape (m, 3): shape (n, 3).

    The cross products of the edges at a vertex, over the squares of their lengths: exact on a sphere, of second order on smooth
    surfaces (Max 1999, J. Graph. Tools 4(2), 1).
    """
    normals = np.zeros_like(vertices)
    for corner in range(3):
        here, after, before = (triangles[:, (corner + k) % 3] for k in range(3))
        one, other = vertices[after] - vertices[here], vertices[before] - vertices[here]
        lengths = (one * one).sum(axis=1) * (other * other).sum(axis=1)
        np.add.at(normals, here, np.cross(one, other) / lengths[:, None])
    return normals / np.linalg.norm(normals, axis=1)[:, None]
