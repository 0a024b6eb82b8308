"""Regions: nodes and faces by shape, named set, normal and boundary, of solids and membranes."""

import re

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from pellucid.geometry.meshes.cells import vector_areas
from pellucid.geometry.meshes.simplex_mesh import SimplexMesh
from pellucid.geometry.region import Region, Selectable, Where, chosen_faces, chosen_nodes, faults
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.geometry.surfaces.triangles import Disc, Icosphere

ADAPTER = TypeAdapter(Where)
EDGE = 0.1
BOX = box_mesh(np.zeros(3), np.full(3, EDGE), (3, 3, 3))
TOP = np.isclose(BOX.nodes[:, 2], EDGE)
SETS = {"top": np.flatnonzero(TOP), "one": np.array([0])}
SOLID = Selectable.of_solid(SimplexMesh(BOX.nodes, BOX.cells, SETS))
AROUND_CORNER = {"sphere": {"centre": (EDGE, EDGE, EDGE), "radius": 0.0601}}
LOWER_HALF = {"box": {"lower": (-1, -1, -1), "upper": (1, 1, 0.05)}}


def where(data):
    return ADAPTER.validate_python(data)


def on_surface(places):
    return np.isclose(places, 0.0).any(axis=1) | np.isclose(places, EDGE).any(axis=1)


def in_sphere(places):
    return np.linalg.norm(places - EDGE, axis=1) <= 0.0601


NODES = {
    "boundary": ("boundary", on_surface),
    "named set": ({"set": "top"}, lambda x: np.isclose(x[:, 2], EDGE)),
    "sphere": (AROUND_CORNER, in_sphere),
    "normal": ({"normal": (0, 0, 2)}, lambda x: np.isclose(x[:, 2], EDGE)),
    "any normal": ({"normal": (1, 1, 1), "within": 180}, on_surface),
    "half the normals": ({"normal": (1, 1, 1), "within": 89}, lambda x: np.isclose(x, EDGE).any(axis=1)),
    "patch": (AROUND_CORNER | {"normal": (0, 0, 1), "within": 10}, lambda x: in_sphere(x) & np.isclose(x[:, 2], EDGE)),
    "set in a sphere": (AROUND_CORNER | {"set": "top"}, lambda x: in_sphere(x) & np.isclose(x[:, 2], EDGE)),
}


@pytest.mark.parametrize("name", NODES)
def test_nodes_of_a_solid(name):
    data, wanted = NODES[name]
    expected = wanted(BOX.nodes)
    assert 0 < expected.sum() < len(BOX.nodes)
    assert np.array_equal(chosen_nodes(where(data), SOLID), expected)


@pytest.mark.parametrize("name", NODES)
def test_faces_are_those_whose_corners_are_chosen(name):
    """Of a cube, on whose edges no face lies, those of the chosen nodes."""
    data, wanted = NODES[name]
    corners = wanted(BOX.nodes)[SOLID.faces].all(axis=1)
    assert np.array_equal(chosen_faces(where(data), SOLID), corners)


@pytest.mark.parametrize(("axis", "sign"), [(axis, sign) for axis in range(3) for sign in (-1.0, 1.0)])
def test_a_face_of_a_cube_by_its_normal_has_its_area(axis, sign):
    normal = sign * np.eye(3)[axis]
    faces = SOLID.faces[chosen_faces(Region(normal=tuple(normal), within=1.0), SOLID)]
    assert vector_areas(SOLID.position, faces).sum(axis=0) == pytest.approx(EDGE**2 * normal, abs=1e-16)


def test_a_cap_of_a_sphere_by_its_normal_has_the_area_of_the_cap():
    """2π r² (1 - cos 40°), but for a rim of one triangle: a fiftieth of the circumference of 2π r sin 40°."""
    ball = Selectable.of_membrane(*Icosphere(centre=(1, 2, 3), radius=2.0, refinements=4).triangulate())
    faces = ball.faces[chosen_faces(Region(normal=(0, 0, 1), within=40.0), ball)]
    area = np.linalg.norm(vector_areas(ball.position, faces), axis=1).sum()
    assert area == pytest.approx(2.0 * np.pi * 4.0 * (1.0 - np.cos(np.radians(40.0))), rel=0.05)
    assert not chosen_nodes("boundary", ball).any(), "a closed surface has no rim"


def test_the_boundary_of_a_membrane_is_its_rim():
    vertices, triangles = Disc(centre=(0, 0, 0), normal=(0, 0, 1), radius=1.0, rings=5).triangulate()
    disc = Selectable.of_membrane(vertices, triangles)
    assert np.array_equal(chosen_nodes("boundary", disc), np.isclose(np.linalg.norm(vertices, axis=1), 1.0))


def test_rounding_does_not_take_nodes_out_of_a_box():
    shifted = Selectable(np.array([[0.1 + 0.2, 0.0, 0.0], [1.0, 0.0, 0.0]]))
    assert chosen_nodes(where({"box": {"lower": (0, 0, 0), "upper": (0.3, 0, 0)}}), shifted).tolist() == [True, False]


def test_the_angle_may_have_a_unit():
    assert Region(normal=(0, 0, 1), within="0.5 rad").within == pytest.approx(np.degrees(0.5))
    assert Region(normal=(0, 0, 1), within="30 deg").within == pytest.approx(30.0)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ({}, "a table with a shape .*, a named `set` or a `normal`"),
        ({"within": 30}, "a table with a shape"),
        (LOWER_HALF | AROUND_CORNER, "can have only one shape, but box, sphere are given"),
        (LOWER_HALF | {"within": 30}, "`within` is given without `normal`"),
        ({"normal": (0, 0, 0)}, "has zero length"),
        ({"normal": (0, 0, 1), "within": 181}, "less than or equal to 180"),
        ({"normal": (0, 0, 1), "within": 0}, "greater than 0"),
        ({"side": "top"}, "Extra inputs"),
    ],
)
def test_regions_that_make_no_sense(data, words):
    with pytest.raises(ValidationError, match=words):
        Region.model_validate(data)


@pytest.mark.parametrize(
    ("data", "of", "faces", "path", "words"),
    [
        ({"set": "topp"}, SOLID, False, ("where", "set"), "no set of this name; its sets are top, one"),
        ({"set": "top"}, Selectable.of_solid(BOX), False, ("where", "set"), "has no named sets"),
        ({"set": "one"}, SOLID, True, ("where",), "no face of body block lies in it at the start"),
        ({"sphere": {"centre": (9, 9, 9), "radius": 1}}, SOLID, False, ("where",), "no node of body block lies in it"),
        ({"normal": (0, 0, 1)}, Selectable(BOX.nodes), False, ("where",), "body block has no mesh of its own"),
        ("boundary", Selectable(BOX.nodes), False, ("where",), "body block has no mesh of its own"),
        ({"sphere": {"centre": (9, 9, 9), "radius": 1}}, Selectable(BOX.nodes), False, ("where",), "no point of body block"),
    ],
)
def test_what_a_body_does_not_have_is_told(data, of, faces, path, words):
    (found,) = faults(where(data), of, ("where",), "block", faces=faces)
    assert found.path == path
    assert re.search(words, found.text)
    if data == {"set": "topp"}:
        assert found.remedy == "did you mean `top`?"


TILTED = {"normal": (1, 1, 0), "within": 40}


@pytest.mark.parametrize(
    ("data", "of", "faces", "words", "remedy"),
    [
        (TILTED, SOLID, False, "normals differ by 45 degrees or more", "set `within` to at least 45, or change `normal`"),
        (LOWER_HALF | {"normal": (0, 0, 1)}, SOLID, False, "", "extend the shape or set to faces with this normal"),
        (LOWER_HALF | {"set": "top"}, SOLID, False, "", "change the shape or the set so that they overlap"),
        ({"set": "one"}, SOLID, True, "though nodes do", "use a set that contains whole faces"),
        (
            {"box": {"lower": (0.03, 0.03, 0), "upper": (0.04, 0.04, 1)}},
            SOLID,
            True,
            "though nodes do",
            "make it larger or move it",
        ),
        ({"sphere": {"centre": (9, 9, 9), "radius": 1}}, SOLID, False, "", "make it larger or move it"),
        ("boundary", Selectable.of_membrane(*Icosphere(radius=1.0, centre=(0, 0, 0)).triangulate()), False, "no rim", "shape"),
    ],
)
def test_what_to_do_about_an_empty_region_fits_how_it_was_chosen(data, of, faces, words, remedy):
    (found,) = faults(where(data), of, ("where",), "block", faces=faces)
    assert "at the start" in found.text
    assert words in found.text
    assert remedy in found.remedy
    if data == TILTED:
        assert not list(faults(where(TILTED | {"within": 45}), of, ("where",), "block"))


@pytest.mark.parametrize("data", [data for data, _ in NODES.values()])
def test_what_is_there_is_no_fault(data):
    assert not list(faults(where(data), SOLID, ("where",), "block"))
