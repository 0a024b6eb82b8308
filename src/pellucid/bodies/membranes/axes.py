"""In-plane axes of a membrane."""

import numpy as np


def axes_along(direction: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return two in-plane unit vectors for planes with normals `normal`, shape (n, 3), of any length. The first vectors, shape
    (n, 3), lie along the projection of `direction`, shape (3,) or one for each plane (n, 3); the second ones are perpendicular
    to them.
    """
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    first = direction - np.sum(direction * normal, axis=1)[:, None] * normal
    first /= np.linalg.norm(first, axis=1)[:, None]
    return first, np.cross(normal, first)
