"""Local weak forms on a line: test functions that are one in a window about each node and zero elsewhere.

The balance of a window, d/dt ∫ c dx = flux in - flux out, is the row of its node (local radial point interpolation, Liu & Gu
2001; Benet 2015, eqs. 4.21 to 4.31). Windows of half the spacing meet and do not overlap: what leaves one enters the next, and
the whole is conserved. To a wave of number k a window of half-width w answers with 2 sin(kw)/k, which has a zero at a wave that
the nodes carry, k < π/h, as soon as w > h. The outflow has one too, at a slightly different wave, as slopes are interpolated:
of a wave between the two they have different signs, and it grows.
"""

from math import ceil
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.approximants.radial.blending import Simplices, blended
from pellucid.approximants.radial.contract import RadialModel
from pellucid.approximants.radial.neighbourhoods import along_curve
from pellucid.approximants.radial.stencils import interpolants

GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(4)  # a window ends within a segment, over which functions are smooth


class Windows(NamedTuple):
    """The rows of n nodes on a line, as sparse matrices of shape (n, n)."""

    content: csr_array  # ∫ N_J dx over the window of node I [m]
    outflow: csr_array  # -dN_J/dx at its upper end plus that at its lower end [1/m]; nothing at the ends of the line


def windows_on_line(x: np.ndarray, radial: RadialModel, half_width: float = 0.5) -> Windows:
    """The windows about nodes at ascending x, shape (n,) [m], cut off at the ends of the line, through which nothing flows.

    half_width: in segments between nodes; they are stable below 1. Raises StencilError where there are too few nodes.
    """
    n = len(x)
    number = np.arange(n - 1)
    segments = Simplices(x[:, None], np.stack([number, number + 1], axis=1), None)
    near = along_curve(x[:, None], radial.stencil_size(1), closed=False)
    found = interpolants(near.coordinates, radial)
    content, outflow = _Sum(n), _Sum(n)
    for beyond in range(ceil(half_width)):  # how many segments lie between that of this part and the node
        part = min(half_width - beyond, 1.0)
        places = part * np.concatenate([0.5 * (GAUSS + 1.0), [1.0]])
        for corner, share in ((0, places), (1, 1.0 - places)):  # upwards from the node, then downwards
            owner = number - beyond if corner == 0 else number + 1 + beyond
            there = np.flatnonzero((owner >= 0) & (owner < n))
            part_of = Simplices(segments.points, segments.corners[there], None)
            rows = blended(part_of, near, found, np.stack([1.0 - share, share], axis=1))
            h = np.diff(x)[there, None]
            content.add(owner[there], rows.nodes, h * np.einsum("q,tqr->tr", 0.5 * part * WEIGHTS, rows.value[:, :-1]))
            if beyond + part == half_width:
                outflow.add(owner[there], rows.nodes, (2.0 * corner - 1.0) * rows.first[:, -1, 0] / h)
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
