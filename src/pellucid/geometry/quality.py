"""How well shaped tetrahedra are: their dihedral angles."""

import numpy as np

_EDGES = ((0, 1, 2, 3), (0, 2, 3, 1), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 2, 0), (2, 3, 0, 1))  # an edge, the corners across


def dihedral_angles(nodes: np.ndarray, cells: np.ndarray) -> np.ndarray:
    """The angles between the faces of tetrahedra at their six edges [degrees], shape (c, 6); of a regular one 70.53."""
    x = nodes[cells]
    angles = []
    for a, b, c, d in _EDGES:
        along = x[:, b] - x[:, a]
        one, other = np.cross(along, x[:, c] - x[:, a]), np.cross(along, x[:, d] - x[:, a])
        across = np.linalg.norm(np.cross(one, other), axis=1)
        angles.append(np.degrees(np.arctan2(across, np.einsum("ij,ij->i", one, other))))
    return np.stack(angles, axis=1)
