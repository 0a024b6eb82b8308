"""Meshes that tests share: squares and cubes with nodes shifted at random, of triangles and tetrahedra."""

import numpy as np
from scipy.spatial import Delaunay

from pellucid.geometry.simplex_mesh import SimplexMesh


def irregular(n, dimension, seed=1, shift=0.25):
    """The unit square or cube with n nodes more than one along an edge; those within a face stay on it."""
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
    """So many cells at random, and a point in each, apart from its faces."""
    rng = np.random.default_rng(seed)
    cells = rng.integers(len(mesh.cells), size=n)
    shares = rng.dirichlet(np.full(mesh.dimension + 1, 2.0), n)
    return cells, np.einsum("ka,kad->kd", shares, mesh.nodes[mesh.cells[cells]])
