"""Local weak forms on a line: test functions that are one in a window around each node and zero elsewhere.

The balance of a quantity with the line density c over a window, d/dt ∫ c dx = flux in - flux out, is the equation of its
node (local radial point interpolation, Liu & Gu 2001; Benet 2015, eqs. 4.21 to 4.31). Windows of half the node spacing h
touch without overlap: the flux out of one window is the flux into the next, and the total is conserved. The response of a
window with half-width w to a wave with wave number k is 2 sin(kw)/k, which has a zero at a resolved wave, k < π/h, if w >
h. The outflow also has a zero, at a slightly different wave number, as slopes are interpolated; for waves between the two
zeros the signs differ, and these waves grow.
"""

from math import ceil
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.approximants.radial.blending import Simplices, blended
from pellucid.approximants.radial.contract import RadialModel
from pellucid.approximants.radial.neighbourhoods import along_curve
from pellucid.approximants.radial.stencils import interpolants

GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(4)  # each part of a window lies in one segment, where functions are smooth


class Windows(NamedTuple):
    """Integrals over the windows of n nodes on a line and outflow at their ends, as sparse matrices of shape (n, n), by which
    nodal values are multiplied."""

    content: csr_array  # ∫ N_J dx over the window of node I [m]
    outflow: csr_array  # -dN_J/dx at the upper end of the window plus dN_J/dx at its lower end [1/m]; 0 at the ends of the line


def windows_on_line(x: np.ndarray, radial: RadialModel, half_width: float = 0.5) -> Windows:
    """Compute the matrices of the windows around nodes at ascending x, shape (n,) [m]. Windows end at the ends of the line,
    where the flux is zero.

    radial: radial function of the shape functions; half_width: half-width of a window in units of segments between nodes;
    stable below 1. Raises StencilError if there are too few nodes.
    """
    n = len(x)
    number = np.arange(n - 1)
    segments = Simplices(x[:, None], np.stack([number, number + 1], axis=1), None)
    near = along_curve(x[:, None], radial.stencil_size(1), closed=False)
    found = interpolants(near.coordinates, radial)
    content, outflow = _Sum(n), _Sum(n)
    for beyond in range(ceil(half_width)):  # number of segments between this part and the node
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
    """Builds a sparse matrix of shape (n, n) by adding entries; entries at the same place are summed."""

    def __init__(self, n: int) -> None:
        self._n = n
        self._entries: list[tuple[np.ndarray, np.ndarray, np.ndarray]] = []

    def add(self, row: np.ndarray, columns: np.ndarray, values: np.ndarray) -> None:
        """Add t r entries to the matrix: values, shape (t, r), in rows, shape (t,), and columns, shape (t, r)."""
        self._entries.append((np.repeat(row, columns.shape[1]), columns.ravel(), values.ravel()))

    def matrix(self) -> csr_array:
        """Return the sum of all added entries as a matrix, shape (n, n)."""
        row, column, value = (np.concatenate(parts) for parts in zip(*self._entries, strict=True))
        return csr_array((value, (row, column)), shape=(self._n, self._n))
