"""Correction of gradients for consistent quadrature, so that the patch test is passed to round-off.

With shape functions p_a and their gradients at the quadrature points q with weights w_q, the error of the divergence theorem is
e_a = ∮ p_a n dS - Σ_q w_q ∇p_a(q). The correction δ_aq = p_a(q) (η_a - [1, x_a] β_q), where β_q is the fit of η by an affine
function at q with the weights p_a(q), preserves the partition of unity and linear reproduction, and Σ_q w_q δ_aq = e_a is one
symmetric system for η, semidefinite with the affine functions in its null space. It is the correction with the least Σ_q w_q
|δ_aq|²/p_a(q). For functions that may be negative, p_a(q) is replaced by |p_a(q)| here. (Chen, Hillman & Rüter 2013, Int. J.
Numer. Methods Eng. 95, 387, state the condition.)

Affine fits of nodal values η_a at the quadrature points: the weights of a fit are c_a = |p_a| of the shape functions p_a of
nodes a at x_a. With C = Σ_b c_b, the centre y = Σ_b c_b x_b / C and J = Σ_b c_b (x_b - y) ⊗ (x_b - y), the fit at x is Σ_b c_b
η_b / C + t·(x - y), t = J⁻¹ Σ_b c_b (x_b - y) η_b. The residual of the fit, multiplied by c_a and the quadrature weights w_q
and summed over the points q, is A η, A_ab = Σ_q w_q c_a (δ_ab - c_b (1/C + (x_a - y)·J⁻¹(x_b - y))).
"""

from typing import NamedTuple

import numpy as np
from scipy import sparse

from pellucid.approximants.nodal.contract import Evaluator, Lists
from pellucid.approximants.nodal.table import PointRows, face_shares
from pellucid.approximants.nodal.two_level import solve
from pellucid.geometry.meshes.cells import outer_faces_of_cells, vector_areas
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.loops import parallel_loop
from pellucid.jit.vector import LANES, load, splat, spread, store
from pellucid.tensors import cofactor, determinant

CELLS = 256  # cells per chunk of a parallel loop
NODES = 64  # nodes per chunk


class Fits(NamedTuple):
    """Shape functions at the quadrature points, with the data of the affine fits of nodal values at these points (see
    `pellucid.approximants.nodal.consistency`), listed by cell and by node."""

    position: np.ndarray  # (n, 3) node positions [m]
    cells: Lists  # the nodes of each cell
    nodes: Lists  # the entries of `cells` that belong to each node
    cell: np.ndarray  # cell of each entry of `cells`
    n_points: int  # quadrature points per cell
    weights: np.ndarray  # (m,) quadrature weights [m³]
    over: np.ndarray  # (m,) 1/C, C: sum of the weights of the fit at a point
    centre: np.ndarray  # (m, 3) centre y of the nodes, weighted [m]
    inverse: np.ndarray  # (m, 3, 3) J⁻¹ [1/m²], J: weighted second moments of the nodes about y
    shares: np.ndarray  # weights c_a = |p_a| of the nodes in the fits, in the layout of `PointRows.values`
    gradients: np.ndarray  # gradients of the shape functions, in the layout of `PointRows.gradients`


def make_fits(position: np.ndarray, cells: Lists, rows: PointRows, weights: np.ndarray) -> Bundle:
    """Compute the data of the affine fits of nodal values (see `pellucid.approximants.nodal.consistency`) at m quadrature
    points. Each cell has the same number of points.

    position: nodes, shape (n, 3) [m]; cells: the active nodes of each cell; rows: the shape functions at the points;
    weights: quadrature weights, shape (m,) [m³].
    """
    n_cells, entries = len(cells.first) - 1, np.argsort(cells.items, kind="stable").astype(np.int32)
    first = np.concatenate([[0], np.cumsum(np.bincount(cells.items, minlength=len(position)))])
    cell = np.repeat(np.arange(n_cells, dtype=np.int32), np.diff(cells.first))
    m, shares = len(weights), rows.values if rows.values.min() >= 0.0 else abs(rows.values)
    found = np.empty(m), np.empty((m, 3)), np.empty((m, 3, 3))
    lists = cells, Lists(first, entries), cell
    fits = Bundle(Fits(position, *lists, m // n_cells, np.ascontiguousarray(weights), *found, shares, rows.gradients))
    _find_fits(-(-n_cells // CELLS), fits)
    return fits


@parallel_loop(allocates=True)
def _find_fits(chunk, fits):
    first, position, nq = fits.cells.first, fits.position, fits.n_points
    for cell in range(CELLS * chunk, min(CELLS * (chunk + 1), len(first) - 1)):
        nodes = fits.cells.items[first[cell] : first[cell + 1]]
        n = len(nodes)
        for q in range(nq):
            point, row, total, y, J = nq * cell + q, nq * first[cell] + q * n, 0.0, np.zeros(3), np.zeros((3, 3))
            for k in range(n):
                total += fits.shares[row + k]
                for i in range(3):
                    y[i] += fits.shares[row + k] * position[nodes[k], i]
            y /= total
            for k in range(n):
                for i in range(3):
                    x = fits.shares[row + k] * (position[nodes[k], i] - y[i])
                    for j in range(3):
                        J[i, j] += x * (position[nodes[k], j] - y[j])
            M = (J[0, 0], J[0, 1], J[0, 2], J[1, 0], J[1, 1], J[1, 2], J[2, 0], J[2, 1], J[2, 2])
            over, C = 1.0 / determinant(M), cofactor(M)
            fits.over[point] = 1.0 / total
            for i in range(3):
                fits.centre[point, i] = y[i]
            for k in range(9):
                fits.inverse[point, k // 3, k % 3] = over * C[k]  # symmetric, as J is


@parallel_loop()
def _find_sums(chunk, fits, sums, sizes):
    first, nq = fits.cells.first, fits.n_points
    for a in range(NODES * chunk, min(NODES * (chunk + 1), len(sums))):
        for place in range(fits.nodes.first[a], fits.nodes.first[a + 1]):
            entry = fits.nodes.items[place]
            cell = fits.cell[entry]
            n = first[cell + 1] - first[cell]
            for q in range(nq):
                row = 3 * (nq * first[cell] + q * n) + entry - first[cell]
                for i in range(3):
                    part = fits.weights[nq * cell + q] * fits.gradients[row + i * n]
                    sums[a, i] += part
                    sizes[a, i] += abs(part)


def quadrature_sums(fits: Bundle) -> tuple[np.ndarray, np.ndarray]:
    """Return, for each node a, Σ_q w_q ∇p_a(q) and Σ_q w_q |∇p_a(q)| with absolute values by component, shape (n, 3) each [m²];
    p_a: shape function, w_q: weight of quadrature point q; fits: bundle of `Fits`."""
    sums, sizes = np.zeros_like(fits.position), np.zeros_like(fits.position)
    _find_sums(-(-len(sums) // NODES), fits, sums, sizes)
    return sums, sizes


@parallel_loop(allocates=True)
def _count(chunk, fits, count):
    seen = np.full(len(count), -1, np.int32)
    for a in range(NODES * chunk, min(NODES * (chunk + 1), len(count))):
        for place in range(fits.nodes.first[a], fits.nodes.first[a + 1]):
            cell = fits.cell[fits.nodes.items[place]]
            for other in range(fits.cells.first[cell], fits.cells.first[cell + 1]):
                b = fits.cells.items[other]
                if seen[b] != a:
                    seen[b] = a
                    count[a] += 1


@kernel(inner=True)
def _add_cell(a, entry, fits, longest, s, row):
    """Add the contribution of one cell of node a to row a of the matrix A of the residuals of affine fits (see `system`).

    entry: index of node a of this cell in `fits.cells.items`. longest: largest number of nodes of a cell. s: scratch memory
    of three columns of this length, followed by four numbers for each quadrature point. row: row a of A, shape (n,) [m³].
    """
    cell, nq, position, centre, inverse = fits.cell[entry], fits.n_points, fits.position, fits.centre, fits.inverse
    shares, weights, over = fits.shares, fits.weights, fits.over
    start = fits.cells.first[cell]
    nodes = fits.cells.items[start : fits.cells.first[cell + 1]]
    n, factors, own = len(nodes), 3 * longest, 0.0
    for k in range(n):
        for i in range(3):
            s[i * longest + k] = position[nodes[k], i] - position[a, i]
    for q in range(nq):
        point = nq * cell + q
        weight = weights[point] * shares[nq * start + q * n + entry - start]
        own += weight
        s[factors + 4 * q] = weight * over[point]
        for i in range(3):
            slope = 0.0
            for j in range(3):
                slope += weight * inverse[point, i, j] * (position[a, j] - centre[point, j])
            s[factors + 4 * q] += slope * (position[a, i] - centre[point, i])
            s[factors + 4 * q + 1 + i] = slope
    whole = n // LANES * LANES
    for k in range(0, whole, LANES):
        x, y, z, part = load(s, k), load(s, longest + k), load(s, 2 * longest + k), splat(0.0)
        for q in range(nq):
            at = factors + 4 * q
            fit = spread(s, at) + spread(s, at + 1) * x + spread(s, at + 2) * y + spread(s, at + 3) * z
            part += load(shares, nq * start + q * n + k) * fit
        store(s, k, part)
    for k in range(whole, n):
        part = 0.0
        for q in range(nq):
            at = factors + 4 * q
            fit = s[at] + s[at + 1] * s[k] + s[at + 2] * s[longest + k] + s[at + 3] * s[2 * longest + k]
            part += shares[nq * start + q * n + k] * fit
        s[k] = part
    for k in range(n):
        row[nodes[k]] -= s[k]
    row[a] += own


@parallel_loop(allocates=True)
def _fill(chunk, fits, longest, first, columns, entries):
    n = len(first) - 1
    seen, row, s = np.full(n, -1, np.int32), np.zeros(n), np.empty(3 * longest + 4 * fits.n_points)
    for a in range(NODES * chunk, min(NODES * (chunk + 1), n)):
        at = first[a]
        for place in range(fits.nodes.first[a], fits.nodes.first[a + 1]):
            entry = fits.nodes.items[place]
            cell = fits.cell[entry]
            for other in range(fits.cells.first[cell], fits.cells.first[cell + 1]):
                b = fits.cells.items[other]
                if seen[b] != a:
                    seen[b] = a
                    columns[at] = b
                    at += 1
            _add_cell(a, entry, fits, longest, s, row)
        for place in range(first[a], first[a + 1]):
            entries[place] = row[columns[place]]
            row[columns[place]] = 0.0


def system(fits: Bundle) -> sparse.csr_array:
    """Return the matrix A that yields, from nodal values η, the residuals A η of their affine fits, weighted and summed
    over the quadrature points, shape (n, n) [m³]; see `pellucid.approximants.nodal.consistency`. It is symmetric and
    semidefinite; affine functions are in its null space.

    fits: bundle of `Fits`.
    """
    n, chunks = len(fits.position), -(-len(fits.position) // NODES)
    count = np.zeros(n, np.int64)
    _count(chunks, fits, count)
    first = np.concatenate([[0], np.cumsum(count)])
    columns, entries = np.empty(int(first[-1]), np.int32), np.empty(int(first[-1]))
    _fill(chunks, fits, int(np.diff(fits.cells.first).max()), first, columns, entries)
    return sparse.csr_array((entries, columns, first), shape=(n, n))


@parallel_loop(allocates=True)
def _correct(chunk, fits, eta):
    first, nodes, nq = fits.cells.first, fits.cells.items, fits.n_points
    moment, slope = np.empty((3, 3)), np.empty((3, 3))
    for cell in range(CELLS * chunk, min(CELLS * (chunk + 1), len(first) - 1)):
        n = first[cell + 1] - first[cell]
        for q in range(nq):
            point, row = nq * cell + q, nq * first[cell] + q * n
            mean, x = np.zeros(3), np.empty(3)
            moment[:] = 0.0
            for k in range(n):
                node, c = nodes[first[cell] + k], fits.shares[row + k]
                for i in range(3):
                    mean[i] += c * eta[node, i]
                    for j in range(3):
                        moment[i, j] += c * (fits.position[node, j] - fits.centre[point, j]) * eta[node, i]
            for i in range(3):
                for j in range(3):
                    slope[i, j] = 0.0
                    for k in range(3):
                        slope[i, j] += moment[i, k] * fits.inverse[point, k, j]
            for k in range(n):
                node, c = nodes[first[cell] + k], fits.shares[row + k]
                for j in range(3):
                    x[j] = fits.position[node, j] - fits.centre[point, j]
                for i in range(3):
                    fitted = fits.over[point] * mean[i] + slope[i, 0] * x[0] + slope[i, 1] * x[1] + slope[i, 2] * x[2]
                    fits.gradients[3 * row + i * n + k] += c * (eta[node, i] - fitted)


def apply_correction(fits: Bundle, eta: np.ndarray) -> None:
    """Add c_a (η_a - affine fit of η) to the gradient of the shape function p_a of each node a at each quadrature point, in
    place.

    eta: nodal values η for the three components of the gradient, shape (n, 3) [1/m]; c_a = |p_a|: weight of the node in the
    fit. fits: bundle of `Fits`.
    """
    _correct(-(-(len(fits.cells.first) - 1) // CELLS), fits, eta)


EXACT = 1e-14  # round-off error of the divergence theorem, relative to its sums, per number of spacings in the extent


def boundary_integrals(mesh: SimplexMesh, evaluator: Evaluator) -> np.ndarray:
    """Return ∮ p_a n dS over the boundary of a tetrahedral mesh for each node a, shape (n, 3) [m²].

    p_a: shape function of the node, defined by `evaluator`; n: outward unit normal.
    """
    faces, cells = outer_faces_of_cells(mesh.cells)
    shares = face_shares(evaluator, mesh.nodes, faces, cells)
    return shares.at_nodes(vector_areas(mesh.nodes, faces), len(mesh.nodes))


def correct(mesh: SimplexMesh, evaluator: Evaluator, rows: PointRows, weights: np.ndarray) -> None:
    """Correct in place the gradients of the shape functions `rows` at the quadrature points of a mesh, so that the
    quadrature satisfies the divergence theorem for each shape function, Σ_q w_q ∇p_a(q) = ∮ p_a n dS (see
    `pellucid.approximants.nodal.consistency`).

    evaluator: defines the shape functions on the boundary; weights: quadrature weights, shape (m,) [m³]. The points of a
    cell are consecutive, with the same number in each cell. Raises Refusal if the system does not converge.
    """
    fits = make_fits(mesh.nodes, evaluator.active, rows, weights)
    sums, sizes = quadrature_sums(fits)
    error = boundary_integrals(mesh, evaluator) - sums
    spacings = float(np.ptp(mesh.nodes, axis=0).max() / mesh.spacing.min())  # loss of digits in differences of coordinates
    if abs(error).max() <= EXACT * spacings * sizes.max():
        return
    matrix = system(fits)
    apply_correction(fits, solve(matrix, error, mesh.nodes))
