"""In-plane axes of a membrane."""

import numpy as np


def axes_along(direction: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return unit axes in planes with these normals, shape (n, 3), of any length: the first along the projection of a
    direction, shape (3,) or one for each plane (n, 3), and the second perpendicular to it."""
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    first = direction - np.sum(direction * normal, axis=1)[:, None] * normal
    first /= np.linalg.norm(first, axis=1)[:, None]
    return first, np.cross(normal, first)
