"""Surface meshes of quadrilaterals and triangles that share vertices."""

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

    Elements are numbered consecutively: quadrilaterals from 0, then triangles from q.
    """

    vertices: np.ndarray
    quads: np.ndarray = NO_QUADS
    triangles: np.ndarray = NO_TRIANGLES

    def triangulated(self) -> Triangulation:
        """Return the triangulation: quadrilaterals divided from their first to their third corner, then the triangles."""
        return Triangulation(self.vertices, np.concatenate([cut_in_two(self.quads), self.triangles]))

    def centres(self) -> np.ndarray:
        """Return the mean corner positions of the elements [m], shape (q + t, 3)."""
        return np.concatenate([self.vertices[corners].mean(axis=1) for corners in (self.quads, self.triangles)])

    def reversed(self) -> "Mesh":
        """Return the mesh with reversed normals. Quadrilaterals keep their first corner, so their triangulation is the same."""
        return Mesh(self.vertices, self.quads[:, [0, 3, 2, 1]], self.triangles[:, ::-1].copy())


class Meshed(Countable):
    """A surface of a case, given as a mesh. Subclasses also define `closed`: True if the surface encloses a volume."""

    @abstractmethod
    def mesh(self) -> Mesh:
        """Return the surface as quadrilaterals and triangles."""

    def triangulate(self) -> Triangulation:
        """Return the triangulation of the mesh, with the same vertices."""
        return self.mesh().triangulated()


def grid_quads(n: int, m: int, wrapped: bool) -> np.ndarray:
    """Return the quadrilaterals between neighbouring points of a grid of n × m points, shape (q, 4); points are numbered
    row by row, n rows of m points; if wrapped, the last row is connected to the first."""
    i, j = np.meshgrid(np.arange(n if wrapped else n - 1), np.arange(m - 1), indexing="ij")
    a, b = (i * m + j).ravel(), ((i + 1) % n * m + j).ravel()
    return np.stack([a, b, b + 1, a + 1], axis=1)


def cut_to_box(vertices: np.ndarray, quads: np.ndarray, bounds: tuple[np.ndarray, np.ndarray], reach: float) -> Mesh:
    """Return the mesh of those quadrilaterals, shape (q, 4), that have all four corners in a box.

    bounds: lower and upper corner of the box [m], shape (3,) each. reach: largest distance of an accepted corner from the
    box [m].
    """
    lower, upper = bounds
    inside = np.asarray(((vertices >= lower - reach) & (vertices <= upper + reach)).all(axis=1))
    used, which = np.unique(quads[inside[quads].all(axis=1)], return_inverse=True)
    return Mesh(vertices[used], which.reshape(-1, 4))
