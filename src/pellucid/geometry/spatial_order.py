"""An order of points in which neighbours in space mostly stand near each other: along Morton's curve."""

import numpy as np

BITS = 10  # of a coordinate


def spatial_order(points: np.ndarray) -> np.ndarray:
    """The order of points [m], shape (n, 3), along the curve, shape (n,); points at one place keep their order."""
    lower = points.min(axis=0)
    extent = max(float((points.max(axis=0) - lower).max()), np.finfo(float).tiny)
    cells = np.minimum((points - lower) / extent * 2**BITS, 2**BITS - 1).astype(np.int64)
    code = np.zeros(len(points), np.int64)
    for bit in range(BITS):
        for axis in range(3):
            code |= (cells[:, axis] >> bit & 1) << (3 * bit + axis)
    return np.argsort(code, kind="stable")
