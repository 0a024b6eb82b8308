"""Closed surfaces filled with tetrahedra by TetGen: their volume to round-off, and what cannot be filled."""

import sys

import numpy as np
import pytest
from boundaries import boundary_edges
from closed_surfaces import CLOSED, red_cell
from pydantic import ValidationError
from scipy.spatial import cKDTree

from pellucid.geometry.checks.quality import dihedral_angles
from pellucid.geometry.checks.solid_checks import solid_faults
from pellucid.geometry.files.writing import write_surface
from pellucid.geometry.meshes.crossing import self_crossing
from pellucid.geometry.meshes.enclosure import enclosed_volume
from pellucid.geometry.meshes.surface_mesh import NO_QUADS
from pellucid.geometry.meshes.triangulation import Triangulation
from pellucid.geometry.solid_meshes.fill import MOST_OFF
from pellucid.geometry.solid_meshes.solid_mesh import SolidMesh
from pellucid.geometry.surfaces.surface import Surface
from pellucid.geometry.surfaces.triangles import Icosphere

RADIUS = 0.5
ASIDE = np.array([0.3, 0.0, 0.0])
BOX = {"box": {"lower": (0, 0, 0), "upper": (1, 2, 3), "points": (2, 2, 2)}}


def ball(refinements, radius=RADIUS):
    return Icosphere(centre=(0, 0, 0), radius=radius, refinements=refinements).triangulate()


def joined(*surfaces):
    counts = np.cumsum([0, *(len(surface.vertices) for surface in surfaces)])
    triangles = [surface.triangles + count for surface, count in zip(surfaces, counts, strict=False)]
    return Triangulation(np.concatenate([surface.vertices for surface in surfaces]), np.concatenate(triangles))


@pytest.fixture
def filled(tmp_path):
    """The mesh of a surface that went through a file."""
    meshlane = pytest.importorskip("meshlane")
    pytest.importorskip("tetgen")

    def fill(surface, size, ending="stl", **table):
        path = tmp_path / f"surface.{ending}"
        options = {"binary": True} if ending == "stl" else {}
        meshlane.write_points_cells(str(path), surface.vertices, [("triangle", surface.triangles)], **options)
        file = {"path": str(path), "closed": True} | table
        return SolidMesh(inside={"surface": {"file": file}, "size": size}).mesh()

    return fill


def test_the_volume_of_a_ball_from_a_file_errs_with_the_square_of_its_triangles(filled):
    missing = []
    for refinements in (1, 2, 3):
        mesh = filled(ball(refinements), 0.2)
        assert list(solid_faults(mesh)) == []
        assert set(boundary_edges(mesh)) == {2}
        missing.append(1.0 - mesh.volumes.sum() / (4.0 / 3.0 * np.pi * RADIUS**3))
    assert missing[-1] < 0.01
    assert np.log2(np.divide(missing[:-1], missing[1:])) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("ending", ["stl", "obj", "ply"])
def test_every_vertex_of_the_file_is_a_node(filled, ending):
    surface = ball(1)
    mesh = filled(surface, 0.3, ending, scale=0.001)
    away = np.linalg.norm(0.001 * surface.vertices[:, None] - mesh.nodes[None], axis=2).min(axis=1)
    assert away.max() < 1e-9


def test_a_box_keeps_its_edges_and_tetrahedra_are_as_small_as_asked():
    pytest.importorskip("tetgen")
    for size in (1.0, 0.3):
        mesh = SolidMesh(inside={"surface": BOX, "size": size}).mesh()
        assert mesh.volumes.sum() == pytest.approx(6.0, rel=1e-12)
        assert mesh.volumes.max() < 2.0 * size**3 / (6.0 * np.sqrt(2.0))  # TetGen moves nodes after the last refinement
        assert dihedral_angles(mesh.nodes, mesh.cells).min() > 3.0  # TetGen promises no bound; these have 4.8 and more


@pytest.mark.parametrize("digits", [7, 6, 5, 3])
@pytest.mark.parametrize("name", ["box", "cylinder"])
def test_flat_parts_that_a_file_rounds_are_filled(tmp_path, name, digits):
    """Where rounding bends flat parts by less than .1 degrees TetGen takes them for flat; else it keeps every edge."""
    pytest.importorskip("tetgen")
    shape = (
        BOX if name == "box" else {"cylinder": {"start": (0, 0, 0), "end": (0, 0, 2), "radius": 0.5, "rings": 3, "along": 5}}
    )
    turned = Surface(**shape, rotate=[{"angle": 30}, {"axis": [1, 0, 0], "angle": 45}]).triangulate()
    rounded = np.array([[float(f"{x:.{digits}g}") for x in place] for place in turned.vertices])
    write_surface(tmp_path / "a.obj", ".obj", rounded, NO_QUADS, turned.triangles)
    file = {"path": str(tmp_path / "a.obj"), "closed": True}
    mesh = SolidMesh(inside={"surface": {"file": file}, "size": 0.5}).mesh()
    volume = enclosed_volume(rounded, turned.triangles)
    assert mesh.volumes.sum() == pytest.approx(volume, rel=MOST_OFF)
    away = cKDTree(mesh.nodes).query(rounded)[0]
    assert away.max() < 1e-12, "every vertex is a node"
    assert list(solid_faults(mesh)) == []


@pytest.mark.parametrize("name", CLOSED)
def test_every_closed_surface_is_filled(name):
    pytest.importorskip("tetgen")
    surface = {name: CLOSED[name]}
    triangles = Surface(**surface).triangulate()
    extent, volume = float(np.ptp(triangles.vertices, axis=0).max()), enclosed_volume(*triangles)
    inside = SolidMesh(inside={"surface": surface, "size": extent / 6})
    assert list(inside.faults()) == []
    assert inside.mesh().volumes.sum() == pytest.approx(volume, rel=1e-12)
    filled = SolidMesh(fill={"shape": {"inside": {"surface": surface}}, "size": extent / 15})
    assert list(filled.faults()) == []
    assert filled.mesh().volumes.sum() == pytest.approx(volume, rel=0.1)


def test_a_fine_sphere_of_quadrilaterals_is_filled():
    """Whose halves meet at more than 179.9 degrees, so that not every edge is kept."""
    pytest.importorskip("tetgen")
    surface = {"sphere": {"centre": (0, 0, 0), "radius": 1.0, "divisions": 16}}
    volume = enclosed_volume(*Surface(**surface).triangulate())
    mesh = SolidMesh(inside={"surface": surface, "size": 0.4}).mesh()
    assert mesh.volumes.sum() == pytest.approx(volume, rel=MOST_OFF)
    assert list(solid_faults(mesh)) == []


def test_a_biconcave_surface_of_a_file_of_single_precision_is_filled(filled):
    cell = red_cell(3)
    mesh = filled(cell, 0.8e-6, unit="um")
    assert mesh.volumes.sum() == pytest.approx(1e-18 * enclosed_volume(*cell), rel=1e-6)
    assert list(solid_faults(mesh)) == []


def test_a_piece_inside_another_is_a_hole(filled):
    inner = ball(2, 0.3)
    mesh = filled(joined(ball(2), inner._replace(triangles=inner.triangles[:, ::-1])), 0.15)
    polyhedron = filled(ball(2), 0.15).volumes.sum()
    assert mesh.volumes.sum() == pytest.approx(polyhedron * (1.0 - 0.6**3), rel=1e-6)  # STL holds seven digits
    assert np.linalg.norm(mesh.nodes, axis=1).min() > 0.28
    assert list(solid_faults(mesh)) == []


def test_surfaces_without_an_inside_are_refused(filled):
    whole = ball(2)
    with pytest.raises(ValidationError, match="the surface is open, so it has no inside"):
        filled(whole, 0.2, closed=False)
    with pytest.raises(
        ValidationError,
        match=r"the surface cannot be filled: the surface is declared closed but has 1 hole with 3 edges in total",
    ):
        filled(whole._replace(triangles=whole.triangles[1:]), 0.2)
    with pytest.raises(ValidationError, match=r"the surface cannot be filled: the normals point inward"):
        filled(whole._replace(triangles=whole.triangles[:, ::-1]), 0.2)


def test_a_surface_that_crosses_itself_is_refused(filled):
    one = ball(2)
    two = joined(one, one._replace(vertices=one.vertices + ASIDE))
    with pytest.raises(
        ValidationError,
        match=r"the surface intersects itself near \(.*\) m; repair the surface at this point, or remove one of",
    ):
        filled(two, 0.2)


def test_where_a_surface_crosses_itself():
    one = ball(2)
    assert self_crossing(one) is None
    place = self_crossing(joined(one, one._replace(vertices=one.vertices + ASIDE)))
    assert np.linalg.norm(place) == pytest.approx(RADIUS, rel=0.03), "triangles lie within the balls, by 2.4 % at their middles"
    assert np.linalg.norm(place - ASIDE) == pytest.approx(RADIUS, rel=0.03)
    assert self_crossing(joined(one, one._replace(vertices=one.vertices + 7.0 * ASIDE))) is None


def test_without_tetgen_the_extra_is_named(monkeypatch):
    monkeypatch.setitem(sys.modules, "tetgen", None)
    with pytest.raises(ValidationError, match=r"tetgen, which .* is not installed; .*pip.* install '\.\[mesh\]' in the clone"):
        SolidMesh(inside={"surface": BOX, "size": 0.123})
