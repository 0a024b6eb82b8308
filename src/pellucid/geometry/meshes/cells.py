"""Cells (points, lines, triangles, ...) between the points of a body, their outer faces, and loads on faces."""

from typing import NamedTuple

import numpy as np

MOST_NODES = 2**21 - 1  # largest number of nodes for which three node numbers can be packed into 63 bits


def _none(corners: int) -> np.ndarray:
    return np.zeros((0, corners), np.int64)


class Cells(NamedTuple):
    """Cells by kind; each row lists the corners of a cell as indices of points of the body.

    Triangles and quadrilaterals are counterclockwise about their normal. The fourth corner of a tetrahedron lies on the side
    from which its first three are counterclockwise.
    """

    points: np.ndarray = _none(1)  # (p, 1)
    lines: np.ndarray = _none(2)  # (l, 2)
    triangles: np.ndarray = _none(3)  # (t, 3)
    quadrilaterals: np.ndarray = _none(4)  # (q, 4)
    tetrahedra: np.ndarray = _none(4)  # (c, 4)

    @classmethod
    def of_points(cls, n: int) -> "Cells":
        """Return one point cell for each of `n` points."""
        return cls(points=np.arange(n).reshape(-1, 1))

    def renumbered(self, number: np.ndarray) -> "Cells":
        """Return the cells after their points are renumbered: point p gets the number number[p]."""
        return Cells(*(number[corners] for corners in self))

    def surface(self) -> np.ndarray:
        """Return the triangles of the visible surface, as point numbers, shape (m, 3): halves of quadrilaterals, then
        triangles, then outer faces of tetrahedra.

        Only faces that belong to one tetrahedron are included, with outward normals.
        """
        return np.concatenate([cut_in_two(self.quadrilaterals), self.triangles, outer_faces(self.tetrahedra)])


def cut_in_two(quads: np.ndarray) -> np.ndarray:
    """Return two triangles for each of q quadrilaterals (node numbers), one after the other, shape (2 q, 3)."""
    return quads[:, [0, 1, 2, 0, 2, 3]].reshape(-1, 3)


def outer_faces(tetrahedra: np.ndarray) -> np.ndarray:
    """Return the faces that belong to only one tetrahedron, as node numbers in the order of outward normals, shape (m, 3).
    tetrahedra: node numbers, shape (c, 4)."""
    return outer_faces_of_cells(tetrahedra)[0]


def outer_faces_of_cells(tetrahedra: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the outer faces, as `outer_faces` does, shape (m, 3), and the index of the tetrahedron to which each face belongs,
    shape (m,). tetrahedra: node numbers, shape (c, 4)."""
    faces = tetrahedra[:, [0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2]].reshape(-1, 3)
    a, b, c = np.sort(faces, axis=1).T
    n = int(tetrahedra.max(initial=0)) + 1
    if n <= MOST_NODES:
        key = (a * n + b) * n + c
    else:
        key = np.unique(np.stack([a, b, c], axis=1), axis=0, return_inverse=True)[1].ravel()
    order = np.argsort(key)
    same = np.diff(key[order]) == 0
    alone = ~(np.append(same, False) | np.append(False, same))
    outer = np.sort(order[alone[: len(order)]])
    return faces[outer], outer // 4


def cells_of_faces(tetrahedra: np.ndarray, faces: np.ndarray) -> np.ndarray:
    """Return the index of the tetrahedron to which each outer face belongs, shape (f,). tetrahedra: node numbers, shape (c, 4);
    faces: corners of the faces in any order, shape (f, 3)."""
    every, cells = outer_faces_of_cells(tetrahedra)
    keys = {tuple(face): cell for face, cell in zip(np.sort(every, axis=1).tolist(), cells.tolist(), strict=True)}
    return np.array([keys[tuple(face)] for face in np.sort(faces, axis=1).tolist()], np.int64)


def vector_areas(places: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the vector areas [m²], shape (m, 3), of triangles between positions [m], shape (n, 3)."""
    a, b, c = places[triangles[:, 0]], places[triangles[:, 1]], places[triangles[:, 2]]
    return np.asarray(0.5 * np.cross(b - a, c - a))


def corner_areas(places: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return for each of n positions [m], shape (n, 3), one third of the sum of the vector areas of the triangles at it
    [m²], shape (n, 3)."""
    thirds = np.repeat(vector_areas(places, triangles) / 3.0, 3, axis=0)
    return np.stack([np.bincount(triangles.ravel(), part, len(places)) for part in thirds.T], axis=1)


class FaceShares(NamedTuple):
    """Fractions of an evenly distributed face load that each node receives: the mean of its shape function over the face.

    The fractions of a face add up to 1.
    """

    face: np.ndarray  # (m,) index of the face
    node: np.ndarray  # (m,) index of the node
    share: np.ndarray  # (m,) fraction of the load on the face that the node receives

    @classmethod
    def linear(cls, faces: np.ndarray) -> "FaceShares":
        """Return the fractions for linear shape functions (a third of the load for each corner) on triangles, given as node
        numbers, shape (f, 3)."""
        n = 3 * len(faces)
        return cls(np.repeat(np.arange(len(faces)), 3), faces.ravel(), np.full(n, 1.0 / 3.0))

    def of(self, chosen: np.ndarray) -> "FaceShares":
        """Return the fractions on the chosen faces only; chosen: mask of the faces, shape (f,)."""
        kept, number = chosen[self.face], np.cumsum(chosen) - 1
        return FaceShares(number[self.face[kept]], self.node[kept], self.share[kept])

    def at_nodes(self, on_faces: np.ndarray, n: int) -> np.ndarray:
        """Return the sums at n nodes, shape (n, 3), of vectors on the faces such as forces (`on_faces`, shape (f, 3)),
        distributed by their fractions."""
        parts = self.share[:, None] * on_faces[self.face]
        return np.stack([np.bincount(self.node, parts[:, axis], n) for axis in range(3)], axis=1)
