"""Turned shapes, surfaces, meshes and regions: places turn, sizes stay."""

import numpy as np
import pytest
from pydantic import ValidationError
from scipy.spatial.transform import Rotation as Turned

from pellucid.geometry.region import Region, Selectable, Shape, chosen_nodes
from pellucid.geometry.shapes.rotation import Rotation
from pellucid.geometry.solid_meshes.solid_mesh import SolidMesh
from pellucid.geometry.surfaces.surface import Surface

SPACE = (True, True, True)
BOX = {"box": {"lower": (-0.2, 0.1, -0.5), "upper": (0.6, 0.4, 0.7)}}
ICOSPHERE = {"icosphere": {"centre": (0.1, 0.0, -0.2), "radius": 0.6, "refinements": 2}}
SHAPES = {
    "box": BOX,
    "sphere": {"sphere": {"centre": (0.1, 0.0, -0.2), "radius": 0.6}},
    "cylinder": {"cylinder": {"centre": (0.1, 0.0, -0.2), "radius": 0.4, "axis": "x", "height": 0.9}},
    "shell": {"shell": {"centre": (0.1, 0.0, -0.2), "outer_radius": 0.6, "inner_radius": 0.3}},
    "pipe": {"pipe": {"centre": (0.1, 0.0, -0.2), "outer_radius": 0.4, "inner_radius": 0.2, "axis": "y", "height": 0.9}},
    "cushion": {"cushion": {"centre": (0.1, 0.0, -0.2), "sides": (0.9, 1.2), "height": 0.4}},
    "half a cushion": {"cushion": {"centre": (0.1, 0.0, -0.2), "sides": (0.9, 1.2), "height": 0.9, "halved": ("x", "z")}},
    "inside": {"inside": {"surface": ICOSPHERE}},
}
ROTATE = [{"angle": 17}, {"axis": (1, 2, -1), "angle": "0.7 rad", "centre": (1, 0, 0.5)}]
every_shape = pytest.mark.parametrize("data", SHAPES.values(), ids=SHAPES)


def turned(points, centre):
    """By another library: about z and the centre, then about a given axis through a given point."""
    one, axis, fixed = Turned.from_euler("z", 17, degrees=True), np.array((1, 2, -1)) / 6.0**0.5, np.array((1, 0, 0.5))
    return fixed + Turned.from_rotvec(0.7 * axis).apply(centre + one.apply(points - centre) - fixed)


def test_all_shapes_are_here():
    assert {key for data in SHAPES.values() for key in data} == set(Shape.alternatives())


@every_shape
def test_what_was_inside_is_inside(data):
    shape, rotated = Shape(**data).geometry(), Shape(**data, rotate=ROTATE).geometry()
    lower, upper = shape.bounds()
    points = np.random.default_rng(2).uniform(lower - 0.1, upper + 0.1, (20_000, 3))
    inside = shape.contains(points, SPACE)
    assert 0.05 < inside.mean() < 0.8
    assert np.array_equal(rotated.contains(turned(points, shape.centre()), SPACE), inside)
    assert rotated.measure(SPACE) == shape.measure(SPACE)
    assert rotated.centre() == pytest.approx(turned(shape.centre()[None], shape.centre())[0], abs=1e-14)


@every_shape
def test_bounds_touch_the_shape(data):
    """From outside: a body that may lie in the grid is not refused, and none that reaches out is let in."""
    shape, rotated = Shape(**data).geometry(), Shape(**data, rotate=ROTATE).geometry()
    lower, upper = shape.bounds()
    lattice = [np.linspace(a, b, 61) for a, b in zip(lower, upper, strict=True)]
    points = np.stack(np.meshgrid(*lattice, indexing="ij"), axis=-1).reshape(-1, 3)
    places = turned(points[shape.contains(points, SPACE)], shape.centre())
    low, high = rotated.bounds()
    assert np.all(places >= low - 1e-12)
    assert np.all(places <= high + 1e-12)
    assert places.min(axis=0) == pytest.approx(low, abs=0.02)
    assert places.max(axis=0) == pytest.approx(high, abs=0.02)


@pytest.mark.parametrize("angle", [-360, -270, -180, -90, 0, 90, 180, 270, 360, "1.5707963267948966 rad"])
def test_quarter_turns_are_exact(angle):
    matrix = Rotation(axis=(0, 3, 0), angle=angle).matrix()
    assert set(np.abs(matrix).ravel()) == {0.0, 1.0}
    degrees = 90.0 if isinstance(angle, str) else angle
    assert matrix == pytest.approx(Turned.from_euler("y", degrees, degrees=True).as_matrix(), abs=1e-12)


def test_a_quarter_turn_has_exact_bounds():
    lower, upper = Shape(**BOX, rotate={"angle": 90, "centre": (0, 0, 0)}).geometry().bounds()
    assert lower.tolist() == pytest.approx([-0.4, -0.2, -0.5], abs=1e-15)
    assert upper.tolist() == pytest.approx([-0.1, 0.6, 0.7], abs=1e-15)


def test_a_plane_shape_turns_in_its_plane():
    """Whatever stands along the thin axis, whose extent does not count."""
    box = Shape(box={"lower": (0, 0, 7), "upper": (2, 1, 7)}, rotate={"angle": 30}).geometry()
    plane = (True, True, False)
    corner = np.array([1.0, 0.5, 99.0]) + Turned.from_euler("z", 30, degrees=True).apply((0.999, 0.499, 0))
    assert box.contains(corner[None], plane).all()
    assert not box.shape.contains(corner[None], plane).any()
    assert box.measure(plane) == 2.0
    lower, upper = box.bounds()
    assert (upper - lower)[:2] == pytest.approx([2 * 0.75**0.5 + 0.5, 1 + 0.75**0.5])


def test_a_turned_pipe_keeps_its_own_points():
    pipe = {"pipe": SHAPES["pipe"]["pipe"] | {"points": (2, 20, 5)}}
    shape, rotated = Shape(**pipe).geometry(), Shape(**pipe, rotate=ROTATE).geometry()
    (points, volumes), (places, shares) = shape.own_points(), rotated.own_points()
    assert rotated.n_own_points() == 200
    assert places == pytest.approx(turned(points, shape.centre()), abs=1e-14)
    assert np.array_equal(volumes, shares)


def test_a_surface_turns_about_the_middle_of_its_bounds():
    data = {"box": BOX["box"] | {"points": (3, 3, 3), "open": ("z-lower",)}}
    still, rotated = Surface(**data), Surface(**data, rotate=ROTATE)
    assert rotated.mesh().vertices == pytest.approx(turned(still.mesh().vertices, np.array([0.2, 0.25, 0.1])), abs=1e-14)
    assert np.array_equal(rotated.mesh().quads, still.mesh().quads)
    assert not rotated.closed
    assert np.array_equal(rotated.triangulate().vertices, rotated.mesh("triangles").vertices)


def test_a_mesh_of_a_solid_turns_and_is_made_once():
    data = {"box": BOX["box"] | {"cells": (2, 1, 3)}}
    still, rotated = SolidMesh(**data), SolidMesh(**data, rotate=ROTATE)
    mesh = rotated.mesh()
    assert mesh.nodes == pytest.approx(turned(still.mesh().nodes, np.array([0.2, 0.25, 0.1])), abs=1e-14)
    assert mesh.volumes == pytest.approx(still.mesh().volumes, rel=1e-12)
    assert rotated.mesh() is mesh
    assert not list(rotated.faults())


def test_a_turned_shape_is_filled_with_tetrahedra():
    mesh = SolidMesh(fill={"shape": BOX | {"rotate": ROTATE}, "size": 0.08}).mesh()
    assert mesh.volumes.sum() == pytest.approx(0.8 * 0.3 * 1.2, rel=0.03)
    back = Shape(**BOX, rotate=ROTATE).geometry().turn.back(mesh.nodes)
    assert np.all((back > np.array(BOX["box"]["lower"]) - 1e-6) & (back < np.array(BOX["box"]["upper"]) + 1e-6))


def test_an_open_surface_that_is_turned_has_no_inside_to_fill():
    tube = {"tube": {"start": (0, 0, 0), "end": (0, 0, 1), "radius": 0.5, "points": (12, 4)}}
    with pytest.raises(ValidationError, match="the surface is open"):
        SolidMesh(fill={"shape": {"inside": {"surface": tube}, "rotate": ROTATE}, "size": 0.2})


def test_a_region_turns_and_rounding_decides_nothing():
    """The nodes on the faces of a turned block lie in the box turned alike, and some do not if it is not turned."""
    nodes = Selectable.of_solid(SolidMesh(box=BOX["box"] | {"cells": (4, 2, 6)}, rotate=ROTATE).mesh())
    assert chosen_nodes(Region(**BOX, rotate=ROTATE), nodes).all()
    assert not chosen_nodes(Region(**BOX), nodes).all()
    assert chosen_nodes(Region(sphere=SHAPES["sphere"]["sphere"], rotate=ROTATE), nodes).any()


@pytest.mark.parametrize(
    ("rotate", "words"),
    [
        ({"angle": 17, "axis": (0, 0, 0)}, "`axis` has zero length; set a direction"),
        ({"angle": 400}, "less than or equal to 360"),
        ({"angle": "3 m"}, "dimension"),
        ({"axis": (0, 0, 1)}, "Field required"),
        ([], "at least 1 item"),
    ],
)
def test_what_is_no_rotation_is_refused(rotate, words):
    with pytest.raises(ValidationError, match=words):
        Shape(**BOX, rotate=rotate)


def test_nothing_but_a_shape_turns():
    with pytest.raises(ValidationError, match="exactly one of the keys box, sphere"):
        Shape(rotate={"angle": 17})
    with pytest.raises(ValidationError, match="`rotate` needs a shape, and this region has none"):
        Region(normal=(0, 0, 1), rotate={"angle": 17})
