"""Meshes of tetrahedra: volumes, faces, nodes."""

import numpy as np
import pytest

from pellucid.geometry.box_mesh import box_mesh

LOWER, UPPER = np.array([-1.0, 0.0, 2.0]), np.array([1.0, 3.0, 2.5])


@pytest.mark.parametrize("counts", [(1, 1, 1), (2, 3, 1), (4, 4, 4)])
def test_tetrahedra_fill_the_box_and_stand_upright(counts):
    mesh = box_mesh(LOWER, UPPER, counts)
    cube = np.prod(UPPER - LOWER) / np.prod(counts)
    assert mesh.volumes == pytest.approx(cube / 12.0, rel=1e-12), "twelve about each middle, or shared with a neighbour"
    assert mesh.volumes.sum() == pytest.approx(np.prod(UPPER - LOWER), rel=1e-12)
    assert (np.bincount(mesh.cells.ravel(), minlength=len(mesh.nodes)) > 0).all(), "every node has a cell"


def test_its_outer_faces_are_those_of_the_box():
    mesh = box_mesh(LOWER, UPPER, (2, 3, 4))
    corners = mesh.nodes[mesh.faces[0][mesh.boundary]]
    on_a_face = np.zeros(len(corners), bool)
    for axis in range(3):
        for end in (LOWER, UPPER):
            on_a_face |= np.isclose(corners[:, :, axis], end[axis], atol=1e-12).all(axis=1)
    assert on_a_face.all()
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    x, y, z = UPPER - LOWER
    assert area.sum() == pytest.approx(2.0 * (x * y + y * z + x * z), rel=1e-12)
