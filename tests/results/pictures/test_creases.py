import numpy as np
import pytest

from pellucid.geometry.meshes.cells import outer_faces
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.geometry.surfaces.triangles import Icosphere
from pellucid.results.pictures.drawables import split_at_creases, vertex_normals


def test_a_box_is_split_along_its_edges():
    mesh = box_mesh(np.zeros(3), np.ones(3), (2, 3, 2))
    faces = outer_faces(mesh.cells)
    found = split_at_creases(mesh.nodes, faces)
    assert (found.vertex[found.triangles] == faces).all(), "the same triangles"
    sides = ((mesh.nodes == 0.0) | (mesh.nodes == 1.0)).sum(axis=1)  # on how many faces of the box a node lies
    shown = np.unique(faces)
    assert np.bincount(found.vertex)[shown].tolist() == sides[shown].tolist()
    normals = vertex_normals(mesh.nodes[found.vertex], found.triangles)
    assert abs(normals).max(axis=1) == pytest.approx(1.0), "each is shaded by the normal of its own face"


def test_round_surfaces_stay_whole():
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=2).triangulate()
    found = split_at_creases(vertices, triangles)
    assert len(found.vertex) == len(vertices)
    turned = triangles.copy()
    turned[::2] = turned[::2, ::-1]
    assert len(split_at_creases(vertices, turned).vertex) > len(vertices), "sides that face opposite ways are not joined"
    assert split_at_creases(vertices, triangles[:0]).triangles.shape == (0, 3)
