"""What closed surfaces enclose: points and volumes against what is known."""

import numpy as np
import pytest

from pellucid.geometry.meshes.enclosure import enclosed_volume, heights, inside, signed_volume
from pellucid.geometry.surfaces.triangles import Icosphere

# a unit cube, two triangles a face, normals outward
CORNERS = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
CUBE = np.array([t for a, b, c, d in FACES for t in ((a, b, c), (a, c, d))])


def together(*surfaces):
    """Several surfaces as one."""
    first = np.cumsum([0] + [len(vertices) for vertices, _ in surfaces])
    triangles = [triangles + n for (_, triangles), n in zip(surfaces, first, strict=False)]
    return np.concatenate([vertices for vertices, _ in surfaces]), np.concatenate(triangles)


def test_a_cube_holds_what_it_holds():
    points = np.random.default_rng(1).uniform(-0.5, 1.5, (20_000, 3))
    within = np.all((points > 0.0) & (points < 1.0), axis=1)
    assert np.array_equal(inside(points, CORNERS, CUBE), within)
    assert enclosed_volume(CORNERS, CUBE) == pytest.approx(1.0, rel=1e-14)
    assert signed_volume(CORNERS, CUBE[:, ::-1]) == pytest.approx(-1.0, rel=1e-14)


def test_rays_through_edges_and_corners_are_counted_once():
    """A lattice whose lines run through the edges, the diagonals and the corners of the faces."""
    axis = np.linspace(-0.5, 1.5, 21)
    points = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    off = np.all(np.abs(np.stack([points, points - 1.0])) > 1e-6, axis=(0, 2))  # on a face either answer is right
    within = np.all((points > 0.0) & (points < 1.0), axis=1)
    assert np.array_equal(inside(points, CORNERS, CUBE)[off], within[off])
    beyond = (points[:, 0] < -1e-6) | (points[:, 0] > 1.0 + 1e-6)
    assert not inside(points, CORNERS, CUBE)[beyond].any(), "also along edges"
    vertices, triangles = Icosphere(centre=(0.5, 0.5, 0.5), radius=1.0, refinements=3).triangulate()
    distance = np.linalg.norm(points - 0.5, axis=1)
    found = inside(points, vertices, triangles)
    assert found[distance < 0.99].all()  # triangles of the third refinement cut in by 0.7 %
    assert not found[distance > 1.0].any()


def test_single_points():
    assert inside(np.array([[0.5, 0.5, 0.5]]), CORNERS, CUBE).tolist() == [True]
    assert inside(np.zeros((0, 3)), CORNERS, CUBE).shape == (0,)


def test_pieces_in_pieces_are_holes_whatever_their_normals():
    outer = (CORNERS * 4.0 - 2.0, CUBE)
    hole = (CORNERS - 0.5, CUBE)
    core = (0.5 * CORNERS - 0.25, CUBE[:, ::-1])
    apart = (CORNERS + 7.0, CUBE)
    vertices, triangles = together(outer, hole, core, apart)
    assert enclosed_volume(vertices, triangles) == pytest.approx(64.0 - 1.0 + 0.125 + 1.0, rel=1e-13)
    points = np.array([[0.1, 0.1, 0.1], [0.4, 0.4, 0.4], [1.0, 1.0, 1.0], [3.0, 3.0, 3.0], [7.5, 7.5, 7.5]])
    assert inside(points, vertices, triangles).tolist() == [True, False, True, False, True]


def test_the_volume_of_an_icosphere_converges_to_that_of_the_sphere():
    """A triangulation of edges h lies within h² of the sphere: the error falls by four with each refinement."""
    errors = [
        1.0 - enclosed_volume(*Icosphere(centre=(1, 2, 3), radius=2.0, refinements=k).triangulate()) / (32.0 / 3.0 * np.pi)
        for k in (2, 3, 4)
    ]
    assert errors[0] / errors[1] == pytest.approx(4.0, rel=0.05)
    assert errors[1] / errors[2] == pytest.approx(4.0, rel=0.05)


def test_heights_are_those_over_the_nearest_triangle():
    """A roof of two slopes at 45°: over a slope, under it, and beyond its edge, where its plane goes on."""
    vertices = np.array([[-1.0, -3, 0], [-1, 3, 0], [0, 0, 1], [1, -3, 0], [1, 3, 0]])
    triangles = np.array([[0, 2, 1], [3, 4, 2]])
    points = np.array([[-0.5, 0.0, 1.5], [0.5, 0.0, 0.25], [1.5, 0.0, 0.0]])
    found = heights(points, vertices, triangles)
    assert found == pytest.approx(np.array([1.0, -0.25, 0.5]) / np.sqrt(2.0), rel=1e-12)
