"""Quadrature on simplices: points in barycentric coordinates, and weights as fractions of the volume.

Rules of 8, 16 and 32 points first divide the tetrahedron: into eight by the midpoints of its edges, or into four by its centre.
Source of the rule of 4 points: Hammer, Marlowe & Stroud 1956, Math. Tables Aids Comput. 10, 130; it is exact to degree 2.
"""

from math import sqrt

import numpy as np

_EDGES = ((0, 1), (0, 2), (0, 3), (1, 2), (1, 3), (2, 3))
# eight of equal volume: four at the corners, four around the diagonal between the midpoints of edges 02 and 13 (Bey 1995,
# Computing 55, 355); numbers from 4 on are midpoints in the order of _EDGES
_EIGHT = ((0, 4, 5, 6), (4, 1, 7, 8), (5, 7, 2, 9), (6, 8, 9, 3), (4, 5, 6, 8), (4, 5, 7, 8), (5, 6, 8, 9), (5, 7, 8, 9))


def _one() -> np.ndarray:
    return np.full((1, 4), 0.25)


def _four() -> np.ndarray:
    near, far = (5.0 + 3.0 * sqrt(5.0)) / 20.0, (5.0 - sqrt(5.0)) / 20.0
    return np.full((4, 4), far) + (near - far) * np.eye(4)


def _in_parts(rule: np.ndarray, parts: np.ndarray) -> np.ndarray:
    """Return the quadrature points of a tetrahedron that is divided into parts: the points of `rule` (barycentric
    coordinates, shape (points, 4)) in each part, in barycentric coordinates of the whole; parts: barycentric coordinates
    of the corners of the parts, shape (parts, 4, 4)."""
    return np.asarray(np.einsum("qk,pkc->pqc", rule, parts).reshape(-1, 4))


def _eight_parts() -> np.ndarray:
    corners = np.concatenate([np.eye(4), [0.5 * (np.eye(4)[a] + np.eye(4)[b]) for a, b in _EDGES]])
    return np.asarray(corners[np.array(_EIGHT)])


def _four_parts() -> np.ndarray:
    parts = np.repeat(np.eye(4)[None], 4, axis=0)
    for corner in range(4):
        parts[corner, corner] = 0.25
    return parts


TETRAHEDRON = {
    1: _one(),
    4: _four(),
    8: _in_parts(_one(), _eight_parts()),
    16: _in_parts(_four(), _four_parts()),
    32: _in_parts(_four(), _eight_parts()),
}
"""Barycentric coordinates of the quadrature points by the number of points of the rule, shape (points, 4); all weights are
1/points."""

# exact to degree 4 (Cowper 1973, Int. J. Numer. Methods Eng. 7, 405)
_NEAR, _FAR = 0.108103018168070, 0.816847572980459
TRIANGLE = np.array(
    [
        *(np.full((3, 3), 0.445948490915965) + (_NEAR - 0.445948490915965) * np.eye(3)),
        *(np.full((3, 3), 0.091576213509771) + (_FAR - 0.091576213509771) * np.eye(3)),
    ]
)
"""Barycentric coordinates of the quadrature points of a triangle, shape (6, 3)."""
TRIANGLE_WEIGHTS = np.repeat([0.223381589678011, 0.109951743655322], 3)
"""Weights of the quadrature points of a triangle, as fractions of its area, shape (6,)."""
