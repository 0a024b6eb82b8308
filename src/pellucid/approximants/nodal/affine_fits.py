"""Affine fits of functions of the nodes at quadrature points, with the shape functions as weights, and the system for them.

With s = Σ_b p_b η_b, J = Σ_b p_b (x_b - x) ⊗ (x_b - x) and t = J⁻¹ Σ_b p_b (x_b - x) η_b, the fit of η at x is s + t·(x_b - x);
what it leaves, times the shape functions and summed over the points, is
A_ab = Σ_q w_q p_a (δ_ab - p_b (1 + (x_a - x)·J⁻¹(x_b - x))).
"""

from typing import NamedTuple

import numpy as np
from scipy import sparse

from pellucid.approximants.nodal.lists import Lists
from pellucid.approximants.nodal.table import Rows
from pellucid.jit import kernel
from pellucid.jit.bundle import Bundle
from pellucid.jit.parallel import parallel_for
from pellucid.jit.vector import LANES, load, splat, spread, store
from pellucid.tensors import cofactor, determinant

CELLS = 256  # that one thread takes at a time
NODES = 64


class Fits(NamedTuple):
    """Shape functions at the quadrature points, by cells and by nodes."""

    position: np.ndarray  # (n, 3) [m]
    cells: Lists  # the nodes of each cell
    nodes: Lists  # the entries of `cells` that are of each node
    cell: np.ndarray  # of each entry
    n_points: int  # of a cell
    points: np.ndarray  # (m, 3) [m]
    weights: np.ndarray  # (m,) [m³]
    inverse: np.ndarray  # (m, 3, 3) J⁻¹ [1/m²]
    values: np.ndarray  # as rows of shape functions have them
    gradients: np.ndarray


def make_fits(position: np.ndarray, cells: Lists, rows: Rows, points: np.ndarray, weights: np.ndarray) -> Bundle:
    """Fits at quadrature points [m], shape (m, 3), with weights [m³], shape (m,), as many points in each cell."""
    n_cells, entries = len(cells.first) - 1, np.argsort(cells.items, kind="stable").astype(np.int32)
    first = np.concatenate([[0], np.cumsum(np.bincount(cells.items, minlength=len(position)))])
    cell = np.repeat(np.arange(n_cells, dtype=np.int32), np.diff(cells.first))
    inverse = np.empty((len(points), 3, 3))
    arrays = np.ascontiguousarray(points), np.ascontiguousarray(weights), inverse, rows.values, rows.gradients
    fits = Bundle(Fits(position, cells, Lists(first, entries), cell, len(points) // n_cells, *arrays))
    _find_inverses(-(-n_cells // CELLS), fits)
    return fits


@kernel(inner=True)
def _inverses_chunk(chunk, fits):
    first, nodes, nq = fits.cells.first, fits.cells.items, fits.n_points
    for cell in range(CELLS * chunk, min(CELLS * (chunk + 1), len(first) - 1)):
        n = first[cell + 1] - first[cell]
        for q in range(nq):
            point, row, J = nq * cell + q, nq * first[cell] + q * n, np.zeros((3, 3))
            for k in range(n):
                for i in range(3):
                    x = fits.values[row + k] * (fits.position[nodes[first[cell] + k], i] - fits.points[point, i])
                    for j in range(3):
                        J[i, j] += x * (fits.position[nodes[first[cell] + k], j] - fits.points[point, j])
            M = (J[0, 0], J[0, 1], J[0, 2], J[1, 0], J[1, 1], J[1, 2], J[2, 0], J[2, 1], J[2, 2])
            over, C = 1.0 / determinant(M), cofactor(M)
            for k in range(9):
                fits.inverse[point, k // 3, k % 3] = over * C[k]  # symmetric, as J is


@kernel()
def _find_inverses(chunks, fits):
    parallel_for(_inverses_chunk, chunks, fits)


@kernel(inner=True)
def _sums_chunk(chunk, fits, sums, sizes):
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


@kernel()
def _find_sums(chunks, fits, sums, sizes):
    parallel_for(_sums_chunk, chunks, fits, sums, sizes)


def quadrature_sums(fits: Bundle) -> tuple[np.ndarray, np.ndarray]:
    """Σ_q w_q ∇p_a(q) [m²] and Σ_q w_q |∇p_a(q)|, component by component, shape (n, 3) each."""
    sums, sizes = np.zeros_like(fits.position), np.zeros_like(fits.position)
    _find_sums(-(-len(sums) // NODES), fits, sums, sizes)
    return sums, sizes


@kernel(inner=True)
def _count_chunk(chunk, fits, count):
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
    """Add what the cell of an entry of node a has to row a; s: scratch of three columns and four numbers to each point."""
    cell, nq, position, points, inverse = fits.cell[entry], fits.n_points, fits.position, fits.points, fits.inverse
    values, weights = fits.values, fits.weights
    start = fits.cells.first[cell]
    nodes = fits.cells.items[start : fits.cells.first[cell + 1]]
    n, factors, own = len(nodes), 3 * longest, 0.0
    for k in range(n):
        for i in range(3):
            s[i * longest + k] = position[nodes[k], i] - position[a, i]
    for q in range(nq):
        point = nq * cell + q
        weight = weights[point] * values[nq * start + q * n + entry - start]
        own += weight
        for i in range(4):
            s[factors + 4 * q + i] = 0.0
        s[factors + 4 * q] = weight
        for i in range(3):
            slope = 0.0
            for j in range(3):
                slope += weight * inverse[point, i, j] * (position[a, j] - points[point, j])
            s[factors + 4 * q] += slope * (position[a, i] - points[point, i])
            s[factors + 4 * q + 1 + i] = slope
    whole = n // LANES * LANES
    for k in range(0, whole, LANES):
        x, y, z, part = load(s, k), load(s, longest + k), load(s, 2 * longest + k), splat(0.0)
        for q in range(nq):
            at = factors + 4 * q
            fit = spread(s, at) + spread(s, at + 1) * x + spread(s, at + 2) * y + spread(s, at + 3) * z
            part += load(values, nq * start + q * n + k) * fit
        store(s, k, part)
    for k in range(whole, n):
        part = 0.0
        for q in range(nq):
            at = factors + 4 * q
            fit = s[at] + s[at + 1] * s[k] + s[at + 2] * s[longest + k] + s[at + 3] * s[2 * longest + k]
            part += values[nq * start + q * n + k] * fit
        s[k] = part
    for k in range(n):
        row[nodes[k]] -= s[k]
    row[a] += own


@kernel(inner=True)
def _fill_chunk(chunk, fits, longest, first, columns, entries):
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


@kernel()
def _count(chunks, fits, count):
    parallel_for(_count_chunk, chunks, fits, count)


@kernel()
def _fill(chunks, fits, longest, first, columns, entries):
    parallel_for(_fill_chunk, chunks, fits, longest, first, columns, entries)


def system(fits: Bundle) -> sparse.csr_array:
    """A [m³], shape (n, n): symmetric, semidefinite, affine functions in its null space."""
    n, chunks = len(fits.position), -(-len(fits.position) // NODES)
    count = np.zeros(n, np.int64)
    _count(chunks, fits, count)
    first = np.concatenate([[0], np.cumsum(count)])
    columns, entries = np.empty(int(first[-1]), np.int32), np.empty(int(first[-1]))
    _fill(chunks, fits, int(np.diff(fits.cells.first).max()), first, columns, entries)
    return sparse.csr_array((entries, columns, first), shape=(n, n))


@kernel(inner=True)
def _correct_chunk(chunk, fits, eta):
    first, nodes, nq = fits.cells.first, fits.cells.items, fits.n_points
    moment, slope = np.empty((3, 3)), np.empty((3, 3))
    for cell in range(CELLS * chunk, min(CELLS * (chunk + 1), len(first) - 1)):
        n = first[cell + 1] - first[cell]
        for q in range(nq):
            point, row = nq * cell + q, nq * first[cell] + q * n
            mean, x = np.zeros(3), np.empty(3)
            moment[:] = 0.0
            for k in range(n):
                node, p = nodes[first[cell] + k], fits.values[row + k]
                for i in range(3):
                    mean[i] += p * eta[node, i]
                    for j in range(3):
                        moment[i, j] += p * (fits.position[node, j] - fits.points[point, j]) * eta[node, i]
            for i in range(3):
                for j in range(3):
                    slope[i, j] = 0.0
                    for k in range(3):
                        slope[i, j] += moment[i, k] * fits.inverse[point, k, j]
            for k in range(n):
                node, p = nodes[first[cell] + k], fits.values[row + k]
                for j in range(3):
                    x[j] = fits.position[node, j] - fits.points[point, j]
                for i in range(3):
                    fitted = mean[i] + slope[i, 0] * x[0] + slope[i, 1] * x[1] + slope[i, 2] * x[2]
                    fits.gradients[3 * row + i * n + k] += p * (eta[node, i] - fitted)


@kernel()
def _correct(chunks, fits, eta):
    parallel_for(_correct_chunk, chunks, fits, eta)


def apply_correction(fits: Bundle, eta: np.ndarray) -> None:
    """Add p_a (η_a - its fit) to the gradients, for η of shape (n, 3)."""
    _correct(-(-(len(fits.cells.first) - 1) // CELLS), fits, eta)
