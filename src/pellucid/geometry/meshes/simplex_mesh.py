"""Simplex mesh: the background mesh of a meshless solid, made of triangles in a plane or of tetrahedra."""

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from scipy import sparse


TOGETHER = 1 << 13  # cells per block, so that a block fits into the cache


def in_parts(n: int) -> Iterator[slice]:
    """Yield consecutive slices that together cover n cells, so that large arrays are processed in parts."""
    return (slice(start, start + TOGETHER) for start in range(0, n, TOGETHER))


class SimplexMesh:
    """Nodes [m], shape (n, 3), and cells, shape (c, 3) or (c, 4): triangles in the plane z = 0, or tetrahedra.

    The corners of a triangle are counterclockwise. The fourth corner of a tetrahedron lies on the side from which the first
    three are counterclockwise. sets: node numbers by set name.
    """

    def __init__(self, nodes: np.ndarray, cells: np.ndarray, sets: Mapping[str, np.ndarray] | None = None) -> None:
        self.nodes, self.cells = np.ascontiguousarray(nodes, float), np.ascontiguousarray(cells, np.int64)
        self.sets = sets or {}

    @property
    def dimension(self) -> int:
        """Dimension of the cells: 2 for triangles, 3 for tetrahedra."""
        return self.cells.shape[1] - 1

    @cached_property
    def volumes(self) -> np.ndarray:
        """Signed volumes of the tetrahedra [m³], areas of the triangles [m²], shape (c,)."""
        volumes = np.empty(len(self.cells))
        for some in in_parts(len(self.cells)):
            corners = self.nodes[self.cells[some]]
            edges = np.moveaxis(corners[:, 1:] - corners[:, :1], 1, 0)
            normal = np.cross(edges[0], edges[1])
            if self.dimension == 2:
                volumes[some] = 0.5 * normal[:, 2]
            else:
                volumes[some] = np.einsum("ci,ci->c", normal, edges[2]) / 6.0
        return volumes

    @cached_property
    def incidence(self) -> "sparse.csr_array":
        """Sparse node-cell incidence matrix: 1 if a cell contains a node, shape (n, c)."""
        from scipy import sparse  # slow import, not needed to read a case

        n, corners = len(self.cells), self.cells.shape[1]
        ones = np.ones(n * corners, np.int32), (self.cells.ravel(), np.repeat(np.arange(n), corners))
        return _sorted(sparse.csr_array(ones, shape=(len(self.nodes), n)))

    @cached_property
    def neighbours(self) -> "sparse.csr_array":
        """Sparse matrix that is nonzero if two nodes share a cell, including the diagonal, shape (n, n)."""
        return _sorted(self.incidence @ self.incidence.T)

    @cached_property
    def spacing(self) -> np.ndarray:
        """Mean length of the edges at each node [m], shape (n,)."""
        links = self.neighbours
        row = np.repeat(np.arange(len(self.nodes)), np.diff(links.indptr))
        length = np.linalg.norm(self.nodes[row] - self.nodes[links.indices], axis=1)
        return np.bincount(row, length, len(self.nodes)) / np.maximum(np.diff(links.indptr) - 1, 1)

    @cached_property
    def faces(self) -> tuple[np.ndarray, np.ndarray]:
        """Faces of the cells (edges of triangles): their nodes in ascending order, shape (f, d), and their two cells, shape (f,
        2).

        The second cell of a boundary face is -1.
        """
        corners = self.cells.shape[1]
        every, owner = faces_of_cells(self.cells), np.tile(np.arange(len(self.cells)), corners)
        order = np.lexsort(every.T[::-1])
        new = np.any(np.diff(every[order], axis=0, prepend=-1), axis=1)
        first = np.append(np.flatnonzero(new), len(every))
        nodes = every[order[first[:-1]]]
        cells = np.full((len(nodes), 2), -1)
        cells[:, 0] = owner[order[first[:-1]]]
        shared = np.diff(first) > 1
        cells[shared, 1] = owner[order[first[:-1][shared] + 1]]
        return nodes, cells

    @property
    def boundary(self) -> np.ndarray:
        """Indices of the boundary faces (faces that belong to only one cell) in `faces`."""
        return np.flatnonzero(self.faces[1][:, 1] < 0)


def faces_of_cells(cells: np.ndarray) -> np.ndarray:
    """Return the nodes of the faces opposite the first corners of all cells, then of those opposite the second corners, and
    so on.

    The nodes of a face are in ascending order: shape (corners c, corners - 1) for c cells.
    """
    corners = range(cells.shape[1])
    return np.sort(np.concatenate([np.delete(cells, left_out, axis=1) for left_out in corners]), axis=1)


def _sorted(matrix: "sparse.csr_array") -> "sparse.csr_array":
    matrix.sort_indices()
    return matrix
