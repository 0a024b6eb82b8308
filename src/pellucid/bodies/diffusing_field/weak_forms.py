"""The matrices of the equations of a diffusing field c at its nodes, M ċ + D K c = 0, on a line and on a closed surface."""

from math import ceil
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.approximants.radial.blending import BlendedRows, Simplices, blended
from pellucid.approximants.radial.functions import RadialModel
from pellucid.approximants.radial.stencils import along_curve, interpolants, on_surface
from pellucid.geometry.meshes.quadrature import TRIANGLE, TRIANGLE_WEIGHTS
from pellucid.geometry.meshes.triangulation import Triangulation, vertex_normals

GAUSS, WEIGHTS = np.polynomial.legendre.leggauss(4)  # each part of a window lies in one segment, where functions are smooth

if TYPE_CHECKING:
    from pellucid.bodies.diffusing_field.model import Line


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

    Test functions are one in a window around each node and zero elsewhere. The balance of a quantity with the line density c
    over a window, d/dt ∫ c dx = flux in - flux out, is the equation of its node (local radial point interpolation, Liu & Gu
    2001; Benet 2015, eqs. 4.21 to 4.31). Windows of half the node spacing h touch without overlap: the flux out of one window
    is the flux into the next, and the total is conserved. The response of a window with half-width w to a wave with wave
    number k is 2 sin(kw)/k, which has a zero at a resolved wave, k < π/h, if w > h. The outflow also has a zero, at a slightly
    different wave number, as slopes are interpolated; for waves between the two zeros the signs differ, and these waves grow.
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


CHUNK = 2048  # triangles that are processed together


class WeakForm(NamedTuple):
    """Matrices M and K of the equation M ċ + D K c = 0 for the concentrations c at n nodes, with the diffusivity D.

    The columns of K sum to 0, so that the amount of solute is conserved, if the intervals of `on_line` adjoin or, on a
    surface, since the test functions are the shape functions.
    """

    content: csr_array  # M (n, n) [m or m²]
    outflow: csr_array  # K (n, n) for D = 1 [1/m or 1]
    share: np.ndarray  # (n,) integrals of the shape functions [m or m²]


def on_line(line: "Line", radial: RadialModel, window: float) -> WeakForm:
    """Return M and K for a line from balances of the amount of solute in an interval (window) around each node.

    radial: settings of the shape functions; window: half-width of the intervals divided by the node spacing (Benet 2015, eqs.
    4.26 to 4.31).
    """
    content, outflow = windows_on_line(line.places(), radial, window)
    meeting = windows_on_line(line.places(), radial).content
    return WeakForm(content, outflow, np.asarray(meeting.sum(axis=0)))


def on_closed_surface(mesh: Triangulation, radial: RadialModel) -> WeakForm:
    """Return the matrices of Galerkin's method for a closed surface, M = ∫ N_I N_J dA and K = ∫ ∇N_I·∇N_J dA, with the
    shape functions N_I of the nodes. The integrals are over the curved surface that the shape functions interpolate between
    the nodes.

    mesh: triangles between the nodes; radial: settings of the shape functions. Uses six quadrature points per triangle;
    three are too few for functions of this order.
    """
    vertices, normals = mesh.vertices, vertex_normals(*mesh)
    near = on_surface(vertices, normals, radial.stencil_size(2))
    found = interpolants(near.coordinates, radial)
    content = outflow = csr_array((len(vertices), len(vertices)))
    for first in range(0, len(mesh.triangles), CHUNK):
        part = Simplices(vertices, mesh.triangles[first : first + CHUNK], normals)
        rows = blended(part, near, found, TRIANGLE)
        along = rows.slopes(vertices)  # (t, q, 2, 3), tangents of the surface
        root = np.linalg.cholesky(along @ np.swapaxes(along, 2, 3))  # its inverse takes derivatives to an orthonormal frame
        weights = (0.5 * TRIANGLE_WEIGHTS * root[..., 0, 0] * root[..., 1, 1]).ravel()
        content = content + _weighed(_sparse(rows, rows.value, len(vertices)), weights)
        gradient = np.linalg.solve(root, rows.first)
        for axis in range(2):
            outflow = outflow + _weighed(_sparse(rows, gradient[:, :, axis], len(vertices)), weights)
    return WeakForm(content, outflow, np.asarray(content.sum(axis=0)))


def _sparse(rows: BlendedRows, entries: np.ndarray, n: int) -> csr_array:
    """Assemble a sparse matrix with one row per quadrature point and one column per node, from shape functions or their
    derivatives.

    rows: the shape functions at the quadrature points, with the nodes of each triangle; entries: values for triangle,
    quadrature point and node of the triangle's stencil, shape (t, q, r); n: number of nodes.
    """
    t, q, r = entries.shape
    columns = np.broadcast_to(rows.nodes[:, None], entries.shape)
    matrix = csr_array((entries.ravel(), columns.ravel(), np.arange(t * q + 1) * r), shape=(t * q, n))
    matrix.sum_duplicates()
    return matrix


def _weighed(matrix: csr_array, weights: np.ndarray) -> csr_array:
    """Return the symmetric matrix Bᵀ W B of a sparse matrix B, where W is the diagonal matrix of the weights, one per row of
    B.
    """
    scaled = matrix.copy()
    scaled.data = matrix.data * np.repeat(weights, np.diff(matrix.indptr))
    return csr_array(matrix.T @ scaled)
