"""Axes in the surface of a membrane."""

import numpy as np


def axes_along(direction: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axes of planes with these normals, shape (n, 3), of any length: along what lies in them of a direction, shape (3,) or of
    each (n, 3), and across it."""
    normal = normal / np.linalg.norm(normal, axis=1)[:, None]
    first = direction - np.sum(direction * normal, axis=1)[:, None] * normal
    first /= np.linalg.norm(first, axis=1)[:, None]
    return first, np.cross(normal, first)
