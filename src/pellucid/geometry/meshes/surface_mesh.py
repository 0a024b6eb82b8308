"""Quadrilaterals and triangles that share vertices: what surfaces are made of."""

from abc import abstractmethod
from typing import NamedTuple

import numpy as np

from pellucid.geometry.meshes.cells import cut_in_two
from pellucid.geometry.meshes.most_points import Countable
from pellucid.geometry.meshes.triangulation import Triangulation

NO_QUADS = np.zeros((0, 4), np.int64)
NO_TRIANGLES = np.zeros((0, 3), np.int64)


class Mesh(NamedTuple):
    """Vertices [m], shape (n, 3), quadrilaterals, shape (q, 4), and triangles, shape (t, 3), counterclockwise about the normal.

    Elements are counted through: the quadrilaterals from 0, then the triangles from q.
    """

    vertices: np.ndarray
    quads: np.ndarray = NO_QUADS
    triangles: np.ndarray = NO_TRIANGLES

    def triangulated(self) -> Triangulation:
        """Return the vertices, and triangles: quadrilaterals cut from their first to their third corner, then the others."""
        return Triangulation(self.vertices, np.concatenate([cut_in_two(self.quads), self.triangles]))

    def centres(self) -> np.ndarray:
        """The means of the corners of its elements [m], shape (q + t, 3)."""
        return np.concatenate([self.vertices[corners].mean(axis=1) for corners in (self.quads, self.triangles)])

    def reversed(self) -> "Mesh":
        """The same mesh with its normals on the other side; quadrilaterals keep their first corner, so are cut alike."""
        return Mesh(self.vertices, self.quads[:, [0, 3, 2, 1]], self.triangles[:, ::-1].copy())


class Meshed(Countable):
    """A surface of a case. Beside its mesh it says whether it encloses a volume: `closed`."""

    @abstractmethod
    def mesh(self) -> Mesh:
        """Return the quadrilaterals and triangles."""

    def triangulate(self) -> Triangulation:
        """Return the mesh with every quadrilateral cut in two: the vertices are the same."""
        return self.mesh().triangulated()


def grid_quads(n: int, m: int, wrapped: bool) -> np.ndarray:
    """A quadrilateral for each square of n × m points, shape (q, 4); where wrapped, the last row of squares joins the first."""
    i, j = np.meshgrid(np.arange(n if wrapped else n - 1), np.arange(m - 1), indexing="ij")
    a, b = (i * m + j).ravel(), ((i + 1) % n * m + j).ravel()
    return np.stack([a, b, b + 1, a + 1], axis=1)


def cut_to_box(vertices: np.ndarray, quads: np.ndarray, bounds: tuple[np.ndarray, np.ndarray], reach: float) -> Mesh:
    """Cut a mesh to the quadrilaterals, shape (q, 4), with all corners in a box.

    bounds: lower and upper corner of the box [m], shape (3,) each; reach: by which corners may lie beyond it [m].
    """
    lower, upper = bounds
    inside = np.asarray(((vertices >= lower - reach) & (vertices <= upper + reach)).all(axis=1))
    used, which = np.unique(quads[inside[quads].all(axis=1)], return_inverse=True)
    return Mesh(vertices[used], which.reshape(-1, 4))
