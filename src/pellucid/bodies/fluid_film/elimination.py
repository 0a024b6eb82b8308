"""An order of elimination for matrices of surfaces, and factors of them."""

import numpy as np
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import splu

SMALLEST = 60  # nodes that are not divided


def nested_dissection(blocks: csr_array, places: np.ndarray) -> np.ndarray:
    """Nodes in an order that keeps factors sparse, shape (n,), by their links (n, n) and places (n, 3).

    The surface is cut in two again and again, across its longest extent; the nodes along the cut come last
    (George 1973, SIAM J. Numer. Anal. 10, 345).
    """
    parts: list[np.ndarray] = []
    waiting = [np.arange(len(places))]
    beyond = np.zeros(len(places), np.int8)
    while waiting:  # from the last to the first
        part = waiting.pop()
        if len(part) <= SMALLEST:
            parts.append(part)
            continue
        extent = np.ptp(places[part], axis=0)
        along = places[part, int(extent.argmax())]
        half = np.argsort(along, kind="stable")[: len(part) // 2]
        near = np.zeros(len(part), bool)
        near[half] = True
        beyond[part[~near]] = 1
        touches = (blocks[part] @ beyond) > 0
        beyond[part[~near]] = 0
        parts.append(part[near & touches])
        waiting += [part[near & ~touches], part[~near]]
    return np.concatenate(parts[::-1])


class Factor:
    """The factors of a symmetric positive definite matrix, by rows and columns in an order."""

    def __init__(self, matrix: csr_array, order: np.ndarray) -> None:
        self._order = order
        ordered = csc_array(matrix[order][:, order])
        self._factors = splu(ordered, permc_spec="NATURAL", diag_pivot_thresh=0.0, options={"SymmetricMode": True})

    def solve(self, right: np.ndarray) -> np.ndarray:
        """For a right side, shape (n,)."""
        result = np.empty_like(right)
        result[self._order] = self._factors.solve(right[self._order])
        return result
