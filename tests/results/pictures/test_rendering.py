import numpy as np
import pytest

from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.geometry.surfaces.triangles import Icosphere
from pellucid.results.pictures.camera import Plane, View, camera_for, coloured
from pellucid.results.pictures.drawables import Balls, Mesh, Section, box_corners, bricks, lattice_sides
from pellucid.results.pictures.render import _between, cut_face, inside, render, rim, section

TEAL, RED = (0.1, 0.6, 0.6), (1.0, 0.0, 0.0)
ABOVE = View(-90.0, 60.0)
HALF = Plane((0.0, 0.0, 1.0), 0.25)
RADIUS = 2.0


def sphere(marked=()):
    vertices, triangles = Icosphere(centre=(0, 0, 0), radius=RADIUS, refinements=4).triangulate()
    flags = np.zeros(len(vertices), bool)
    flags[list(marked)] = True
    return Mesh(vertices, triangles, np.tile(TEAL, (len(vertices), 1)), flags, RED)


@pytest.fixture
def camera():
    return camera_for(ABOVE, box_corners(np.full(3, -2.0), np.full(3, 2.0)), 200)


def red(picture):
    return (picture[:, :, 0] > 2.0 * picture[:, :, 1]) & (picture[:, :, 3] > 0.0)


def test_a_view_is_a_right_handed_frame():
    axes = View(35.0, 20.0).axes()
    assert np.allclose(axes @ axes.T, np.eye(3))
    assert np.linalg.det(axes) == pytest.approx(1.0)
    assert np.allclose(View(-90.0, 0.0).axes(), [[1, 0, 0], [0, 0, 1], [0, -1, 0]]), "from the front x is right, z up"


def test_the_picture_holds_what_it_shall(camera):
    corners = box_corners(np.full(3, -2.0), np.full(3, 2.0))
    place = camera.project(corners)
    rows, columns = camera.shape
    assert place[:, 0].min() > 0.0
    assert place[:, 1].min() > 0.0
    assert place[:, 0].max() < columns == 200
    assert place[:, 1].max() < rows
    assert np.allclose(camera.position(*place.T), corners)


def test_a_sphere_covers_a_disc(camera):
    picture = render([sphere()], camera)
    area = (picture[:, :, 3] > 0.0).sum() / camera.scale**2
    assert area == pytest.approx(np.pi * RADIUS**2, rel=0.01)  # the polyhedron's outline lies within the circle
    assert not red(picture).any()


def test_one_marked_point_shows(camera):
    towards_eye = np.argmax(sphere().vertices @ camera.axes[2])
    assert red(render([sphere(marked=[towards_eye])], camera)).any()
    assert not red(render([sphere(marked=[towards_eye])], camera, Plane((0.0, 0.0, 1.0), 0.0))).any(), "it is cut away"


def test_a_cut_takes_what_lies_beyond_it_away_and_nothing_else(camera):
    """Triangles that lie beyond as a whole are left out beforehand: the others keep their numbers."""
    colours = np.random.default_rng(2).random((len(sphere().vertices), 3))
    ball = sphere()._replace(colours=colours, lit=False)
    beyond = HALF.beyond(ball.vertices)[ball.triangles]
    lower = ball._replace(triangles=ball.triangles[beyond.min(axis=1) <= 0.0])
    assert 0.4 < len(lower.triangles) / len(ball.triangles) < 0.8
    assert np.array_equal(render([ball], camera, HALF), render([lower], camera, HALF))
    parts = [np.concatenate(parts) for parts in zip(*ball.fragments(camera, HALF), strict=True)]
    x, y, depth, which = parts
    assert camera.keeps(HALF, x, y, depth).all()
    a, b, c = (camera.project(ball.vertices)[ball.triangles[which, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    place = np.stack([x, y, depth], axis=1) - a
    assert np.allclose(np.einsum("ki,ki->k", normal, place), 0.0, atol=1e-6), "each lies in its triangle"


def test_rows_between_are_linear():
    given = np.array([[0.0, 10.0], [3.0, 40.0], [9.0, 10.0]])
    found = _between(given, 3, 8)
    assert np.allclose(found[:, 0], [0.0, 1.0, 2.0, 3.0, 5.0, 7.0, 9.0, 9.0])
    assert np.allclose(found[::3], given)
    assert np.allclose(_between(given[:1], 3, 2), given[0])


def test_the_nearer_thing_hides_the_other(camera):
    behind = Balls(-3.0 * camera.axes[2:], np.array([0.5]), np.array([RED]), lit=False)
    before = Balls(3.0 * camera.axes[2:], np.array([0.5]), np.array([RED]), lit=False)
    assert not red(render([behind, sphere()], camera)).any()
    assert red(render([before, sphere()], camera)).any()


def test_inside_is_the_disc_of_the_cut(camera):
    area = inside(sphere(), camera, HALF).sum() / camera.scale**2
    circle = np.pi * (RADIUS**2 - HALF.offset**2)
    assert area == pytest.approx(circle * np.sin(np.radians(ABOVE.rise)), rel=0.02)  # seen aslant


def test_a_section_shows_the_field_on_the_plane(camera):
    position = np.random.default_rng(1).uniform(-2.0, 2.0, (20_000, 3))
    slope = np.array([0.3, -0.2, 0.5])
    found = section(sphere(), camera, HALF, position, position @ slope)
    y, x = np.nonzero(np.isfinite(found))
    wanted = camera.position(x, y, camera.depth_of(HALF, x, y)) @ slope
    assert np.abs(found[y, x] - wanted).max() < 0.15  # points are 0.15 apart; the field changes by 0.6 over a length
    assert np.abs(found[y, x] - wanted).mean() < 0.02


def test_a_painted_section_is_seen_where_the_cut_bares_it(camera):
    values = np.where(inside(sphere(), camera, HALF), 1.0, np.nan)
    paint = Section(HALF, coloured(values, (0.0, 1.0), "Reds"))
    picture = render([sphere(), paint], camera, HALF)
    shown = np.isfinite(values)
    assert np.allclose(picture[shown][:, :3], paint.colours[shown], atol=1e-6), "as it is, without light and shadow"


def test_the_rim_has_the_thickness_of_the_membrane():
    ribbon = rim(sphere(), HALF, 0.3, TEAL)
    assert np.allclose(ribbon.vertices[:, 2], HALF.offset, atol=1e-3)
    assert (ribbon.vertices[:, 2] > HALF.offset).all(), "it covers the painted plane"
    a, b, c = (ribbon.vertices[ribbon.triangles[:, k]] for k in range(3))
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    circle = np.sqrt(RADIUS**2 - HALF.offset**2)
    assert area == pytest.approx(2.0 * np.pi * circle * 0.3, rel=0.005)  # a polygon of about 100 sides
    across = np.linalg.norm(ribbon.vertices[0::2] - ribbon.vertices[1::2], axis=1)
    assert np.allclose(across, 0.3)


def test_the_rim_is_marked_where_the_membrane_is():
    vertices = sphere().vertices
    ribbon = rim(sphere(marked=np.flatnonzero(vertices[:, 0] > 0.0)), HALF, 0.3, TEAL)
    assert (ribbon.vertices[ribbon.marked > 0.5][:, 0] > -0.2).all()
    assert (ribbon.vertices[ribbon.marked < 0.5][:, 0] < 0.2).all()


def test_no_rim_where_nothing_is_cut():
    assert rim(sphere(), Plane((0.0, 0.0, 1.0), 5.0), 0.3, TEAL).primitives == 0


def test_the_cut_face_of_a_solid_is_its_section():
    nodes, cells = (lambda mesh: (mesh.nodes, mesh.cells))(box_mesh(np.array([-1.0, -1, -1]), np.array([1.0, 2, 3]), (3, 4, 5)))
    normal = np.array([0.3, -0.5, 0.8]) / np.linalg.norm([0.3, -0.5, 0.8])
    slope = np.array([[0.1, 0.0, 0.05], [0.0, 0.1, 0.0], [0.02, 0.03, 0.1]])
    for plane, area in (
        (Plane((0.0, 0.0, 1.0), 0.37), 6.0),
        (Plane(tuple(normal), 0.4), None),
        (Plane((1.0, 0.0, 0.0), 5.0), 0.0),
    ):
        face = cut_face(nodes, cells, nodes @ slope, plane)
        assert abs(plane.beyond(face.vertices)).max(initial=0.0) < 1e-12
        assert face.colours == pytest.approx(face.vertices @ slope)
        a, b, c = (face.vertices[face.triangles[:, k]] for k in range(3))
        found = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
        if area is None:  # from the volume between two planes that are close together
            thin = 1e-4
            points = np.random.default_rng(3).uniform((-1, -1, -1), (1, 2, 3), (400_000, 3))
            share = (abs(points @ normal - plane.offset) < 50 * thin).mean()
            assert found == pytest.approx(24.0 * share / (100 * thin), rel=0.05)  # 4500 points are within: 1.5 %
        else:
            assert found == pytest.approx(area, abs=1e-12)
    whole = cut_face(nodes, cells, nodes @ slope, Plane((0.0, 0.0, 1.0), 0.2))
    assert whole.primitives > 0, "a plane through a layer of nodes"


def test_bricks_are_closed_and_look_outward():
    boxes = bricks(np.array([[0.0, 1.0, 2.0], [5.0, 5.0, 5.0]]), np.array([1.0, 2.0, 3.0]), TEAL)
    a, b, c = (boxes.vertices[boxes.triangles[:, k]] for k in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6.0
    assert volume[:12].sum() == pytest.approx(6.0)
    assert volume[12:].sum() == pytest.approx(6.0)


def test_bricks_side_by_side_make_one_body():
    block = bricks(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.01, 0.0]]), np.ones(3), TEAL)
    assert block.primitives == 2 * (3 * 6 - 4)
    assert bricks(np.zeros((0, 3)), np.ones(3), TEAL).primitives == 0


@pytest.mark.parametrize("counts", [(2, 7, 5), (1, 4, 3), (1, 1, 6), (1, 1, 1)])
def test_sides_of_a_lattice(counts):
    sides = np.array([7.5, 10.0, 7.5])
    position = sides * np.stack(np.meshgrid(*map(np.arange, counts), indexing="ij"), axis=-1).reshape(-1, 3)
    position += np.random.default_rng(7).normal(0.0, 1e-9, position.shape)
    found = lattice_sides(position, np.full(len(position), np.prod(sides)))
    assert np.prod(found) == pytest.approx(np.prod(sides))
    several = np.array(counts) > 1
    assert found[several] == pytest.approx(sides[several], rel=1e-6)


def test_a_skin_is_flat_where_it_is_cut(camera):
    low = Balls(np.array([[0.0, 0.0, 0.2]]), np.array([1.0]), np.array([TEAL]), skin=True)
    x, y, depth, _ = (np.concatenate(parts) for parts in zip(*low.fragments(camera, HALF), strict=True))
    beyond = HALF.beyond(camera.position(x, y, depth))
    assert beyond.max() == pytest.approx(0.0, abs=1e-12)
    assert (np.abs(beyond) < 1e-9).mean() > 0.5


@pytest.mark.parametrize("at", [0.0, 1.9])
def test_a_body_with_a_skin_is_smooth(camera, at):
    lattice = box_corners(np.array([at - 0.1, -0.1, -0.1]), np.array([at + 0.1, 0.1, 0.1]))
    balls = Balls(lattice, np.full(8, 0.15), np.tile(TEAL, (8, 1)), skin=True)
    picture = render([balls], camera)
    assert np.isfinite(picture).all()
    assert picture[:, :, 3].any()
