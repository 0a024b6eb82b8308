"""Nodes at one place."""

import numpy as np

COINCIDENT = 1e-6  # of the mean length of the lines between neighbours: far above rounding, far below any spacing that is meant


def coincident(places: np.ndarray, sides: np.ndarray) -> tuple[int, int] | None:
    """The first two of n nodes at places [m], shape (n, d), that are at one place, be they neighbours or not; None without.

    sides: corners of the elements between them, shape (m, corners); their mean length says what one place is.
    """
    from scipy.spatial import cKDTree

    corners = places[sides]
    mean = float(np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).mean())
    pairs = cKDTree(places).query_pairs(COINCIDENT * mean, output_type="ndarray")
    if not len(pairs):
        return None
    one, other = min(map(tuple, np.sort(pairs, axis=1).tolist()))
    return one, other
