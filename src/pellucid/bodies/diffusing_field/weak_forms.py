"""The matrices of the equations of a diffusing field c at its nodes, M ċ + D K c = 0, on a line and on a closed surface."""

from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_array

from pellucid.approximants.radial.blending import BlendedRows, Simplices, blended
from pellucid.approximants.radial.contract import RadialModel
from pellucid.approximants.radial.neighbourhoods import on_surface
from pellucid.approximants.radial.stencils import interpolants
from pellucid.approximants.radial.windows import windows_on_line
from pellucid.bodies.diffusing_field.domain import Line
from pellucid.geometry.meshes.quadrature import TRIANGLE, TRIANGLE_WEIGHTS
from pellucid.geometry.meshes.triangulation import Triangulation, vertex_normals

CHUNK = 2048  # triangles that are processed together


class WeakForm(NamedTuple):
    """Matrices M and K of the equation M ċ + D K c = 0 for the concentrations c at n nodes, with the diffusivity D.

    The columns of K sum to 0, so that the amount of solute is conserved, if the intervals of `on_line` adjoin or, on a
    surface, since the test functions are the shape functions.
    """

    content: csr_array  # M (n, n) [m or m²]
    outflow: csr_array  # K (n, n) for D = 1 [1/m or 1]
    share: np.ndarray  # (n,) integrals of the shape functions [m or m²]


def on_line(line: Line, radial: RadialModel, window: float) -> WeakForm:
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
