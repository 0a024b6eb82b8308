"""Where bodies stand as a run begins."""

from typing import NamedTuple

import numpy as np


class Standing(NamedTuple):
    """Where a body stands, of n points."""

    position: np.ndarray
    """Of the points [m], shape (n, 3)."""
    triangles: np.ndarray | None = None
    """Of a membrane, shape (m, 3): their points."""
    volume: np.ndarray | None = None
    """Of the points [m³], shape (n,), where they tell more than the shape of the body does."""
