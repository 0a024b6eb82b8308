"""Meshes of triangles and tetrahedra for several tests: squares, cubes and an L with nodes shifted at random."""

from itertools import permutations

import numpy as np
from scipy.spatial import Delaunay

from pellucid.geometry.meshes.simplex_mesh import SimplexMesh


def irregular(n, dimension, seed=1, shift=0.25):
    """Return a mesh of the unit square or cube with n + 1 nodes along an edge. Inner coordinates are shifted at random by
    `shift` spacings, so that nodes on a face stay on it."""
    axes = [np.linspace(0.0, 1.0, n + 1)] * dimension
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), -1).reshape(-1, dimension)
    inner = (nodes > 0.0) & (nodes < 1.0)
    nodes = nodes + inner * np.random.default_rng(seed).uniform(-shift, shift, nodes.shape) / n
    cells = Delaunay(nodes).simplices
    volume = np.linalg.det(nodes[cells[:, 1:]] - nodes[cells[:, :1]])
    thick = abs(volume) > 1e-6 / n**dimension  # without the slivers on the faces
    cells, volume = cells[thick], volume[thick]
    cells[volume < 0] = cells[volume < 0][:, [1, 0, *range(2, dimension + 1)]]
    return SimplexMesh(np.pad(nodes, ((0, 0), (0, 3 - dimension))), cells)


def points_within(mesh, n, seed=0):
    """Return n random cells of a mesh and a random point inside each, shape (n, 3)."""
    rng = np.random.default_rng(seed)
    cells = rng.integers(len(mesh.cells), size=n)
    shares = rng.dirichlet(np.full(mesh.dimension + 1, 2.0), n)
    return cells, np.einsum("ka,kad->kd", shares, mesh.nodes[mesh.cells[cells]])


def l_shape(n, seed=1, shift=0.2):
    """Return the box with edges 2, 2 and 1 without the quarter with x and y above 1, with n cubes of six tetrahedra per
    unit of length.

    Inner nodes are shifted at random, except nodes on the planes x = 1 and y = 1.
    """
    counts = np.array([2 * n, 2 * n, n])
    cubes = np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), -1).reshape(-1, 3)
    cubes = cubes[(cubes[:, :2] < n).any(axis=1)]
    steps = np.eye(3, dtype=int)
    cells = []
    for order in permutations(range(3)):  # from the lowest corner of a cube to the highest, an axis at a time
        path = np.cumsum([np.zeros(3, int), *(steps[axis] for axis in order)], axis=0)
        odd = np.linalg.det(steps[list(order)]) < 0
        cells.append(cubes[:, None] + path[[1, 0, 2, 3] if odd else [0, 1, 2, 3]])
    corners = np.concatenate(cells).reshape(-1, 3)
    lattice, which = np.unique(corners, axis=0, return_inverse=True)
    nodes = lattice / n
    inner = ((lattice > 0) & (lattice < counts)).all(axis=1) & (lattice[:, :2] != n).all(axis=1)
    nodes[inner] += np.random.default_rng(seed).uniform(-shift, shift, (int(inner.sum()), 3)) / n
    return SimplexMesh(nodes, which.reshape(-1, 4))
