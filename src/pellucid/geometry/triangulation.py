"""Triangles that share vertices: what surfaces are made of."""

from typing import NamedTuple

import numpy as np


class Triangulation(NamedTuple):
    """Vertices [m], shape (n, 3), and triangles, shape (m, 3), counterclockwise about the normal."""

    vertices: np.ndarray
    triangles: np.ndarray


def grid_triangles(n: int, m: int, wrapped: bool) -> np.ndarray:
    """Two triangles for each square of n × m points; where wrapped, the last row of squares joins the first."""
    i, j = np.meshgrid(np.arange(n if wrapped else n - 1), np.arange(m - 1), indexing="ij")
    a, b = (i * m + j).ravel(), ((i + 1) % n * m + j).ravel()
    lower, upper = np.stack([a, b, b + 1], axis=1), np.stack([a, b + 1, a + 1], axis=1)
    return np.stack([lower, upper], axis=1).reshape(-1, 3)


def pieces(triangles: np.ndarray, n: int) -> np.ndarray:
    """For each of n vertices the smallest vertex of its connected piece, shape (n,)."""
    label = np.arange(n)
    one, other = np.concatenate([triangles[:, :2], triangles[:, 1:]]).T
    while True:
        before = label.copy()
        smallest = np.minimum(label[one], label[other])
        np.minimum.at(label, one, smallest)
        np.minimum.at(label, other, smallest)
        np.minimum.at(label, before, label)  # the name of a piece is renamed with any of its vertices
        label = label[label]
        if np.array_equal(label, before):
            return label
