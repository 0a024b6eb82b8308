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


def directed_edges(triangles: np.ndarray) -> np.ndarray:
    """The edges of each triangle in its turn, shape (3 m, 2): all the first ones, all the second ones, all the third ones."""
    a, b, c = triangles.T
    return np.concatenate([np.stack(pair, axis=1) for pair in ((a, b), (b, c), (c, a))])


def two_across(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors that with the direction of `normal` make a right-handed frame, shape (3,) each."""
    direction = normal / np.linalg.norm(normal)
    first = np.cross(direction, np.eye(3)[np.argmin(np.abs(direction))])
    first /= np.linalg.norm(first)
    return first, np.cross(direction, first)


def pieces(links: np.ndarray, n: int) -> np.ndarray:
    """For each of n vertices the smallest one that links, shape (m, 2), lead to from it, shape (n,)."""
    label = np.arange(n)
    one, other = links.T
    while True:
        before = label.copy()
        smallest = np.minimum(label[one], label[other])
        np.minimum.at(label, before[one], smallest)  # the name of a piece is renamed, and with it all that bear it
        np.minimum.at(label, before[other], smallest)
        label = label[label]
        if np.array_equal(label, before):
            return label
