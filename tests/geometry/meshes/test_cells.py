import numpy as np

from pellucid.geometry.meshes.cells import Cells, cut_in_two, outer_faces

CUBE = np.array([[i, j, k] for i in (0, 1) for j in (0, 1) for k in (0, 1)], float)
# Kuhn's six tetrahedra of a cube, each along a path of edges from corner 0 to corner 7
TETRAHEDRA = np.array([[0, 4, 6, 7], [0, 6, 2, 7], [0, 2, 3, 7], [0, 3, 1, 7], [0, 1, 5, 7], [0, 5, 4, 7]])


def test_quadrilaterals_are_cut_from_their_first_to_their_third_corner():
    quads = np.array([[0, 1, 2, 3], [3, 2, 5, 4]])
    assert cut_in_two(quads).tolist() == [[0, 1, 2], [0, 2, 3], [3, 2, 5], [3, 5, 4]]


def test_the_outer_faces_of_tetrahedra_enclose_their_volume():
    a, b, c, d = (CUBE[TETRAHEDRA[:, k]] for k in range(4))
    assert np.all(np.einsum("ij,ij->i", np.cross(b - a, c - a), d - a) > 0.0), "the cells are turned as Cells says"
    faces = outer_faces(TETRAHEDRA)
    assert len(faces) == 12
    a, b, c = (CUBE[faces[:, k]] for k in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0 == 1.0  # divergence theorem: positive where normals point outwards


def test_the_surface_has_quadrilaterals_triangles_and_faces_but_no_points():
    cells = Cells(triangles=np.array([[0, 1, 2]]), quadrilaterals=np.array([[0, 1, 2, 3]]), tetrahedra=np.array([[0, 4, 6, 7]]))
    assert cells.surface().tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2], [0, 6, 4], [0, 4, 7], [4, 6, 7], [0, 7, 6]]
    assert Cells.of_points(3).surface().shape == (0, 3)
    assert Cells.of_points(3).points.tolist() == [[0], [1], [2]]
