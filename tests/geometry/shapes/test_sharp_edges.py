"""Sharp edges and corners of shapes."""

import numpy as np
import pytest

from pellucid.geometry.meshes.triangulation import Triangulation
from pellucid.geometry.region import Shape
from pellucid.geometry.shapes.contract import edges_of_triangles

SPACE, PLANE, LINE = (True, True, True), (True, True, False), (True, False, False)


def edges(active=SPACE, spacing=0.1, **shape):
    return Shape.model_validate(shape).geometry().sharp_edges(active, spacing)


def planes(found):
    a, b, c = (found.corner[found.face[:, column]] for column in range(3))
    normal = np.cross(b - a, c - a)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    return normal, np.einsum("ij,ij->i", normal, a)


BOX = {"box": {"lower": (1, 2, 3), "upper": (2, 4, 6)}}


def test_a_box_has_twelve_edges_eight_corners_and_six_planes():
    found = edges(**BOX)
    assert (len(found.corner), len(found.edge), len(found.face)) == (8, 12, 6)
    outwards = (found.corner - (1.5, 3.0, 4.5)) / (0.5, 1.0, 1.5)
    assert found.corner_normal == pytest.approx(outwards / np.sqrt(3.0))
    middle = found.corner[found.edge].mean(axis=1)
    outwards = (middle - (1.5, 3.0, 4.5)) / (0.5, 1.0, 1.5)
    assert found.edge_normal == pytest.approx(outwards / np.sqrt(2.0))
    normal, level = planes(found)
    assert sorted(map(tuple, np.column_stack([normal, level]).round(12) + 0.0)) == [
        (-1, 0, 0, -1), (0, -1, 0, -2), (0, 0, -1, -3), (0, 0, 1, 6), (0, 1, 0, 4), (1, 0, 0, 2)
    ]  # fmt: skip


def test_in_a_plane_corners_are_left_and_on_a_line_nothing():
    found = edges(PLANE, **BOX)
    assert (len(found.corner), len(found.edge)) == (4, 0)
    way = found.corner[found.face[:, 1]] - found.corner[found.face[:, 0]]
    outside = np.cross(way, (0, 0, 1))
    middle = 0.5 * (found.corner[found.face[:, 1]] + found.corner[found.face[:, 0]])
    assert (np.einsum("ij,ij->i", outside, middle - found.corner.mean(axis=0)) > 0.0).all()
    assert len(edges(LINE, **BOX).corner) == 0


def test_edges_turn_with_the_shape():
    found = edges(**BOX, rotate={"axis": (0, 0, 1), "angle": 90})
    assert found.corner.min(axis=0) == pytest.approx([0.5, 2.5, 3.0])
    normal, _ = planes(found)
    assert np.abs(normal).sum(axis=1) == pytest.approx(1.0)
    assert np.einsum("ij,ij->i", found.corner_normal, found.corner - found.corner.mean(axis=0)).min() > 0.0


@pytest.mark.parametrize("shape", ["sphere", "shell", "cushion"])
def test_round_shapes_have_none(shape):
    given = {
        "sphere": {"centre": (0, 0, 0), "radius": 1},
        "shell": {"centre": (0, 0, 0), "outer_radius": 1, "inner_radius": 0.5},
        "cushion": {"centre": (0, 0, 0), "sides": (1, 1), "height": 0.2},
    }
    assert len(edges(**{shape: given[shape]}).corner) == 0
    ball = {"surface": {"icosphere": {"centre": (0, 0, 0), "radius": 1, "refinements": 2}}}
    assert len(edges(inside=ball).edge) == 0


def test_a_cylinder_has_rims_without_corners():
    found = edges(cylinder={"centre": (0, 0, 0), "radius": 0.5, "axis": "y", "height": 2})
    assert np.abs(found.corner[:, 1]) == pytest.approx(1.0)
    assert np.linalg.norm(found.corner[:, [0, 2]], axis=1) == pytest.approx(0.5)
    assert not found.corner_normal.any()
    assert len(found.face) == 0
    assert np.linalg.norm(np.diff(found.corner[found.edge], axis=1)[:, 0], axis=1).max() < 0.1
    assert len(edges(PLANE, cylinder={"centre": (0, 0, 0), "radius": 0.5, "axis": "z", "height": 2}).corner) == 0
    assert len(edges(PLANE, cylinder={"centre": (0, 0, 0), "radius": 0.5, "axis": "y", "height": 2}).face) == 4


def test_a_pipe_has_inner_rims_too():
    found = edges(pipe={"centre": (0, 0, 0), "outer_radius": 1, "inner_radius": 0.5, "axis": "z", "height": 1})
    inner = np.linalg.norm(found.corner[found.edge].mean(axis=1)[:, :2], axis=1) < 0.75
    outwards = np.einsum("ij,ij->i", found.edge_normal[:, :2], found.corner[found.edge].mean(axis=1)[:, :2])
    assert (outwards[inner] < 0.0).all()
    assert (outwards[~inner] > 0.0).all()


def test_no_planes_bound_a_shape_with_a_dent():
    """A house whose roof is pushed in: its upper edges along the walls are sharp, the valleys are none."""
    base = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    vertices = np.array([*base, (0.5, 0.5, 0.4)], float)
    sides = [(0, 3, 2, 1), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)]
    triangles = [corners for a, b, c, d in sides for corners in ((a, b, c), (a, c, d))]
    roof = [(4, 5, 8), (5, 6, 8), (6, 7, 8), (7, 4, 8)]
    dented = edges_of_triangles(Triangulation(vertices, np.array([*triangles, *roof])))
    assert len(dented.face) == 0
    assert len(dented.corner) == 8
    raised = vertices.copy()
    raised[8, 2] = 1.5
    whole = edges_of_triangles(Triangulation(raised, np.array([*triangles, *roof])))
    assert (len(whole.face), len(whole.corner)) == (9, 9)
