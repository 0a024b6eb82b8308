"""Local weak forms on a line: test functions that are one in a window about each node and zero elsewhere.

The balance of a window, d/dt ∫ c dx = flux in - flux out, is the row of its node (local radial point interpolation, Liu & Gu
2001; Benet 2015, eqs. 4.21 to 4.31). Windows of half the spacing meet and do not overlap: what leaves one enters the next, and
the whole is conserved. To a wave of number k a window of half-width w answers with 2 sin(kw)/k, which has a zero at a wave that
the nodes carry, k < π/h, as soon as w > h: such windows cannot see that wave, and it grows.
"""

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.approximants.radial.blending import Simplices, blended
from pellucid.approximants.radial.contract import RadialModel
from pellucid.approximants.radial.neighbourhoods import along_curve

GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(4)  # a window ends within a segment, over which functions are smooth


class Windows(NamedTuple):
    """The rows of n nodes on a line, as sparse matrices of shape (n, n)."""

    content: csr_array  # ∫ N_J dx over the window of node I [m]
    outflow: csr_array  # -dN_J/dx at its upper end plus that at its lower end [1/m]; nothing at the ends of the line


def windows_on_line(x: np.ndarray, radial: RadialModel, half_width: float = 0.5) -> Windows:
    """The windows about nodes at ascending x, shape (n,) [m].

    half_width: over the spacing on either side, less than 2 and stable up to 1. Raises StencilError where there are too few
    nodes.
    """
    n, h = len(x), np.diff(x)
    number = np.arange(n - 1)
    segments = Simplices(x[:, None], np.stack([number, number + 1], axis=1), None)
    near = along_curve(x[:, None], radial.stencil_size(1), closed=False)
    places = half_width * np.concatenate([0.5 * (GAUSS + 1.0), [1.0]])
    content, outflow = _Sum(n), _Sum(n)
    for owner, share in ((0, places), (1, 1.0 - places)):
        rows = blended(segments, near, radial, np.stack([1.0 - share, share], axis=1))
        inside = np.einsum("q,tqr->tr", 0.5 * half_width * WEIGHTS, rows.value[:, :-1]) * h[:, None]
        content.add(number + owner, rows.nodes, inside)
        outflow.add(number + owner, rows.nodes, (2.0 * owner - 1.0) * rows.first[:, -1, 0] / h[:, None])
    return Windows(content.matrix(), outflow.matrix())


class _Sum:
    """A sparse matrix of shape (n, n) as a sum of entries."""

    def __init__(self, n: int) -> None:
        self._n = n
        self._entries: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def add(self, row: np.ndarray, columns: np.ndarray, values: np.ndarray) -> None:
        """Rows (t,) with columns and values (t, r)."""
        self._entries.append((np.repeat(row, columns.shape[1]), columns.ravel(), values.ravel()))

    def matrix(self) -> csr_array:
        """The sum."""
        row, column, value = (np.concatenate(parts) for parts in zip(*self._entries, strict=True))
        return csr_array((value, (row, column)), shape=(self._n, self._n))
