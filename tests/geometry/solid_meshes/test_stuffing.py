"""Tetrahedra that fill regions: how well shaped, how much of the volume, whole boundaries."""

import warnings

import numpy as np
import pytest
from boundaries import boundary_edges
from pydantic import ValidationError

from pellucid.geometry.checks.quality import dihedral_angles
from pellucid.geometry.checks.solid_checks import solid_faults
from pellucid.geometry.meshes.cells import outer_faces, vector_areas
from pellucid.geometry.region import Shape
from pellucid.geometry.solid_meshes.fill import stuffed
from pellucid.geometry.solid_meshes.solid_mesh import SolidMesh

GUARANTEED = 10.7, 164.8
"""Smallest and largest dihedral angles [degrees] of Labelle & Shewchuk 2007, table 1, for their cuts of the same lattice."""
BALL = {"sphere": {"centre": (1.0, 2.0, 3.0), "radius": 1.0}}
SHAPES = {
    "sphere": BALL,
    "cylinder": {"cylinder": {"centre": (0, 0, 0), "radius": 1.0, "height": 1.5, "axis": "x"}},
    "shell": {"shell": {"centre": (0, 0, 0), "outer_radius": 1.0, "inner_radius": 0.6}},
    "box": {"box": {"lower": (0, 0, 0), "upper": (1.0, 1.5, 0.77)}},
    "inside": {"inside": {"surface": {"icosphere": {"centre": (0, 0, 0), "radius": 1.0, "refinements": 2}}}},
}


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("size", [0.2, 0.13])
def test_cells_are_sound_and_well_shaped(name, size):
    mesh = SolidMesh(fill={"shape": SHAPES[name], "size": size}).mesh()
    assert list(solid_faults(mesh)) == []
    angles = dihedral_angles(mesh.nodes, mesh.cells)
    assert angles.min() > GUARANTEED[0]
    assert angles.max() < GUARANTEED[1]
    assert set(boundary_edges(mesh)) == {2}, "the boundary is whole and touches itself nowhere"


def test_outer_nodes_lie_on_the_sphere_and_the_volume_errs_with_the_square_of_the_size():
    missing = []
    for size in (0.4, 0.2, 0.1):
        mesh = SolidMesh(fill={"shape": BALL, "size": size}).mesh()
        outer = mesh.nodes[np.unique(mesh.faces[0][mesh.boundary])]
        assert np.linalg.norm(outer - (1.0, 2.0, 3.0), axis=1) == pytest.approx(1.0, abs=1e-10)
        missing.append(1.0 - mesh.volumes.sum() / (4.0 / 3.0 * np.pi))
    orders = np.log2(np.divide(missing[:-1], missing[1:]))
    assert missing[-1] < 0.003
    assert orders[-1] == pytest.approx(2.0, abs=0.2)


def test_faces_of_the_lattices_box_are_flat_and_end_sharp():
    mesh = stuffed(lambda points: np.linalg.norm(points, axis=1) <= 1.0, np.array([-1.05, -1.05, -1.2]), (14, 14, 8), 0.15)
    at_face = mesh.nodes[:, 2] > -1e-9
    assert mesh.nodes[at_face, 2] == pytest.approx(0.0, abs=1e-12)
    faces = mesh.faces[0][mesh.boundary]
    corners = mesh.nodes[faces[at_face[faces].all(axis=1)]]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1).sum()
    assert area == pytest.approx(np.pi, rel=0.015)  # a polygon within the circle whose sides are about 0.15: 2 % at most
    rim = at_face[np.unique(faces[~at_face[faces].all(axis=1)])]
    on_rim = mesh.nodes[np.unique(faces[~at_face[faces].all(axis=1)])][rim]
    assert np.linalg.norm(on_rim, axis=1) == pytest.approx(1.0, abs=1e-10)


TURN = [{"angle": 30}, {"axis": [1, 0, 0], "angle": 45}]
PIPE = {"pipe": {"centre": (0, 0, 0), "outer_radius": 2.0, "inner_radius": 1.0, "height": 1.0, "axis": "z"}}
PLANE_ENDS = {
    "box": (SHAPES["box"], 2 * (1.0 * 1.5 + 1.0 * 0.77 + 1.5 * 0.77)),
    "turned box": (SHAPES["box"] | {"rotate": TURN}, 2 * (1.0 * 1.5 + 1.0 * 0.77 + 1.5 * 0.77)),
    "cylinder": (SHAPES["cylinder"], 5 * np.pi),
    "turned cylinder": (SHAPES["cylinder"] | {"rotate": TURN}, 5 * np.pi),
    "pipe": (PIPE, 12 * np.pi),
    "surface": ({"inside": {"surface": {"box": {"lower": (0, 0, 0), "upper": (1, 1, 2), "points": (2, 2, 2)}}}}, 10.0),
}


@pytest.mark.parametrize("name", PLANE_ENDS)
@pytest.mark.filterwarnings("error")
def test_sharp_edges_of_plane_ends_are_kept(name):
    """Cut edges took 5 % of the area of the box; the sides of the polygons within round shapes err with their square."""
    data, area = PLANE_ENDS[name]
    shape = Shape(**data)
    for size in (0.3, 0.13):
        mesh = SolidMesh(fill={"shape": data, "size": size}).mesh()
        found = float(np.linalg.norm(vector_areas(mesh.nodes, outer_faces(mesh.cells)), axis=1).sum())
        slack = 0.1 * size**2 if "box" not in name and name != "surface" else 1e-12
        assert found == pytest.approx(area, rel=slack)
        assert mesh.volumes.sum() == pytest.approx(shape.geometry().measure((True, True, True)), rel=slack)


def test_edges_that_are_cut_off_are_named():
    oblique = {"cylinder": {"start": (0, 0, 0), "end": (1, 1, 1), "radius": 0.5, "rings": 4, "along": 5}}
    with pytest.warns(UserWarning, match=r"`fill` cuts off sharp edges of the shape, 6\.\d* m in total, .*Use the mesh"):
        SolidMesh(fill={"shape": {"inside": {"surface": oblique}}, "size": 0.141})


def write_prism(path, polygon, height):
    """Write the surface of a prism on a convex polygon in the plane z = 0 to an STL file."""
    low = np.column_stack([polygon, np.zeros(len(polygon))])
    high, turned = low + np.array([0, 0, height]), np.roll(np.arange(len(polygon)), -1)
    fans = [(low[[0, i + 1, i]], high[[0, i, i + 1]]) for i in range(1, len(polygon) - 1)]
    sides = [((low[i], low[j], high[j]), (low[i], high[j], high[i])) for i, j in enumerate(turned)]
    facets = [
        "\n".join("vertex {:.7g} {:.7g} {:.7g}".format(*p) for p in triangle) for pair in fans + sides for triangle in pair
    ]
    loops = (f"facet normal 0 0 0\nouter loop\n{facet}\nendloop\nendfacet" for facet in facets)
    path.write_text("\n".join(["solid prism", *loops, "endsolid prism\n"]))
    return {"inside": {"surface": {"file": {"path": str(path), "closed": True}}}}


SQUARE = np.array([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
TOUCHING = {  # polygons that touch the planes of their bounds with edges, and the length of edges that are cut off
    "trapezoid": ([(0, 0), (1, 0), (0.7, 0.5), (0.3, 0.5)], 0.0),
    "triangle": ([(0, 0), (1, 0), (0.5, 0.85)], 0.5),
    **{
        f"square turned by {angle}": (SQUARE @ [[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]], 2.0)
        for angle, a in ((0.01, 1.7e-4), (3, 0.052), (30, 0.52))
    },
}


@pytest.mark.parametrize("name", TOUCHING)
def test_a_shape_that_touches_its_bounds_with_an_edge_has_no_face_there(tmp_path, name):
    """The lattice does not end there: tetrahedra without volume would result, and cut edges would not be named."""
    polygon, cut = TOUCHING[name]
    shape = write_prism(tmp_path / "prism.stl", np.array(polygon), 0.5)
    with warnings.catch_warnings(record=True) as found:
        warnings.simplefilter("always")
        mesh = SolidMesh(fill={"shape": shape, "size": 0.13}).mesh()
    angles = dihedral_angles(mesh.nodes, mesh.cells)
    assert angles.min() > GUARANTEED[0]
    assert angles.max() < GUARANTEED[1]
    assert {f"{cut:.3g} m in total" in str(warning.message) for warning in found} == ({True} if cut else set())


def test_a_lattice_much_thicker_than_the_shape_is_refused():
    plate = {"box": {"lower": (0, 0, 0), "upper": (1, 1, 0.01)}}
    words = r"`size` = 0\.2 m is too large: the shape extends only 0\.01 m along z; decrease `size` to at most 0\.02"
    with pytest.raises(ValidationError, match=words):
        SolidMesh(fill={"shape": plate, "size": 0.2})


@pytest.mark.parametrize(
    ("size", "words"),
    [
        (1.0, r"the mesh has 64 % of the volume of the shape; the error must be at most 10 %; decrease `size`"),
        (1e-3, r"the mesh would have about 1.6e\+10 points, but at most 2e\+06 are allowed; make the mesh coarser"),
    ],
)
def test_a_lattice_too_coarse_or_too_fine_is_refused(size, words):
    with pytest.raises(ValidationError, match=words):
        SolidMesh(fill={"shape": BALL, "size": size})


def test_nothing_inside_is_refused():
    with pytest.raises(
        ValueError, match=r"`size` = 0\.5 m is too large: no node of the lattice lies inside the region; decrease `size`"
    ):
        stuffed(lambda points: np.zeros(len(points), bool), np.zeros(3), (2, 2, 2), 0.5)


def test_parts_that_touch_along_an_edge_alone_are_refused():
    def two_cubes(points):
        return ((points[:, 0] <= 0.0) & (points[:, 1] <= 0.0)) | ((points[:, 0] >= 0.0) & (points[:, 1] >= 0.0))

    with pytest.raises(ValueError, match="two parts of the mesh are connected only by an edge at"):
        stuffed(two_cubes, np.array([-1.0, -1.0, -1.0]), (8, 8, 8), 0.25)


def test_the_surface_of_what_is_filled_must_be_closed():
    ball = {"file": {"path": __file__}}
    with pytest.raises(ValidationError):
        SolidMesh(fill={"shape": {"inside": {"surface": ball}}, "size": 0.1})
    tube = {"tube": {"start": (0, 0, 0), "end": (0, 0, 1), "radius": 0.5, "points": (12, 5)}}
    with pytest.raises(ValidationError, match="the surface is open, so it has no inside"):
        SolidMesh(fill={"shape": {"inside": {"surface": tube}}, "size": 0.1})
