"""Initial positions of bodies."""

from typing import NamedTuple

import numpy as np


class Standing(NamedTuple):
    """Initial positions of the n points of a body."""

    position: np.ndarray
    """Positions of the points [m], shape (n, 3)."""
    triangles: np.ndarray | None = None
    """Triangles of a membrane, shape (m, 3), as point numbers."""
    volume: np.ndarray | None = None
    """Volumes of the points [m³], shape (n,), if they are more accurate than the shape of the body."""
