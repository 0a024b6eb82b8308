"""Surfaces from files: what was written comes back, in every format; what is no surface is named."""

import sys

import numpy as np
import pytest
from pydantic import ValidationError

from pellucid import load
from pellucid.case import dumps, loads
from pellucid.errors import CaseError
from pellucid.geometry.checks.surface_checks import faults
from pellucid.geometry.surfaces.file import SurfaceFile
from pellucid.geometry.surfaces.triangles import Icosphere

BALL = Icosphere(centre=(0, 0, 0), radius=2.0, refinements=2).triangulate()
FORMATS = {
    "stl": ("stl", {"binary": False}),
    "binary stl": ("stl", {"binary": True}),
    "obj": ("obj", {}),
    "ply": ("ply", {"binary": False}),
    "binary ply": ("ply", {"binary": True}),
    "gmsh": ("msh", {"file_format": "gmsh"}),
    "vtk": ("vtk", {}),
    "vtu": ("vtu", {}),
}
CASE = """
schema = 1
title = "A bag"
[grid]
lower = [-3, -3, -3]
upper = [3, 3, 3]
cell = 1.0
[time]
end = 0.1
[[body]]
name = "bag"
kind = "membrane-points"
surface = { file = { path = "parts/bag.stl", closed = true } }
thickness = 0.01
material = { kind = "linear-membrane", density = 1000, young_modulus = 1e5, poisson_ratio = 0.3 }
"""


@pytest.fixture
def meshlane():
    return pytest.importorskip("meshlane")


@pytest.mark.parametrize("form", FORMATS)
def test_what_was_written_comes_back(meshlane, tmp_path, form):
    ending, options = FORMATS[form]
    path = tmp_path / f"ball.{ending}"
    meshlane.write_points_cells(path, BALL.vertices, [("triangle", BALL.triangles)], **options)
    table = {"path": str(path), "scale": 0.001, "offset": (1, 2, 3), "closed": True}
    vertices, triangles = SurfaceFile(**table).triangulate()
    assert len(vertices) == len(BALL.vertices), "one vertex for each place"
    # a file may hold single precision or text of six digits
    assert vertices[triangles] == pytest.approx(0.001 * BALL.vertices[BALL.triangles] + (1, 2, 3), abs=1e-8)
    assert list(faults(vertices, triangles, closed=True)) == []
    inward = SurfaceFile(**table, reverse=True).triangulate()
    assert "inward" in next(faults(*inward, closed=True))[0]


def test_squares_are_cut_in_two(meshlane, tmp_path):
    path = tmp_path / "sheet.vtk"
    points = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)])
    meshlane.write_points_cells(path, points, [("quad", np.array([(0, 1, 2, 3)]))])
    assert SurfaceFile(path=str(path)).triangulate().triangles.tolist() == [[0, 1, 2], [0, 2, 3]]


def test_squares_and_triangles_are_kept_as_elements(meshlane, tmp_path):
    path = tmp_path / "house.vtk"
    points = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0.5, 2, 0)])
    cells = [("triangle", np.array([(3, 2, 4)])), ("quad", np.array([(0, 1, 2, 3)]))]
    meshlane.write_points_cells(path, points, cells)
    mesh = SurfaceFile(path=str(path)).mesh()
    assert mesh.quads.tolist() == [[0, 1, 2, 3]]
    assert mesh.triangles.tolist() == [[3, 2, 4]]
    turned = SurfaceFile(path=str(path), reverse=True, scale=2.0).mesh()
    assert turned.quads.tolist() == [[0, 3, 2, 1]]
    assert turned.triangles.tolist() == [[4, 2, 3]]
    assert np.array_equal(turned.vertices, 2.0 * points)


def test_a_file_that_changed_is_read_again(meshlane, tmp_path):
    path = tmp_path / "ball.obj"
    for refinements in (1, 2):
        ball = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=refinements).triangulate()
        meshlane.write_points_cells(path, ball.vertices, [("triangle", ball.triangles)])
        assert len(SurfaceFile(path=str(path)).triangulate().vertices) == len(ball.vertices)


def test_files_that_are_no_surface(meshlane, tmp_path):
    solid = tmp_path / "solid.vtk"
    meshlane.write_points_cells(solid, np.eye(4, 3), [("tetra", np.array([(0, 1, 2, 3)]))])
    with pytest.raises(ValueError, match=r"cells of type tetra; a surface may only have triangles"):
        SurfaceFile(path=str(solid))
    lines = tmp_path / "lines.vtk"
    meshlane.write_points_cells(lines, np.eye(4, 3), [("line", np.array([(0, 1)]))])
    with pytest.raises(ValueError, match="contains no triangle"):
        SurfaceFile(path=str(lines))
    broken = tmp_path / "broken.stl"
    broken.write_text("a poem")
    with pytest.raises(ValueError, match="cannot be read as a surface"):
        SurfaceFile(path=str(broken))
    with pytest.raises(ValueError, match="there is no file"):
        SurfaceFile(path=str(tmp_path / "nothing.stl"))


def test_a_path_starts_from_the_folder_of_the_case(meshlane, tmp_path, monkeypatch):
    (tmp_path / "parts").mkdir()
    meshlane.write_points_cells(tmp_path / "parts" / "bag.stl", BALL.vertices, [("triangle", BALL.triangles)], binary=True)
    meshlane.write_points_cells(tmp_path / "parts" / "fine.stl", BALL.vertices, [("triangle", BALL.triangles)], binary=True)
    file = tmp_path / "bag.toml"
    file.write_text(CASE + '[quick]\n"body.bag.surface.file.path" = "parts/fine.stl"\n')
    (tmp_path / "elsewhere").mkdir()
    monkeypatch.chdir(tmp_path / "elsewhere")
    case = load(file)
    assert len(case.body[0].surface.triangulate().vertices) == len(BALL.vertices)
    assert case.quick_variant().body[0].surface.file.path == str(tmp_path / "parts" / "fine.stl")
    assert loads(dumps(case)) == case, "the copy that a run keeps says where the file is"
    with pytest.raises(CaseError, match=r"body.bag.surface.file = .*\n    there is no file"):
        loads(CASE)


def test_without_meshlane_the_extra_is_named(tmp_path, monkeypatch):
    (tmp_path / "a.xdmf").write_text("<Xdmf/>\n")
    monkeypatch.setitem(sys.modules, "meshlane", None)
    with pytest.raises(ValueError, match=r"meshlane, which .* is not installed; .*pip.* install '\.\[mesh\]' in the clone"):
        SurfaceFile(path=str(tmp_path / "a.xdmf"))


def test_corners_that_are_no_points_of_the_file_are_told(tmp_path):
    path = tmp_path / "flap.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n")
    with pytest.raises(
        ValidationError,
        match=r"as a surface: triangle 1 .counted from 0. has a corner that is not one of the 3",
    ):
        SurfaceFile(path=str(path))


def test_a_damaged_file_is_named_without_what_is_in_it(tmp_path):
    path = tmp_path / "secret.obj"
    path.write_text("v my very secret words\n")
    with pytest.raises(ValidationError, match=r"cannot be read as a surface: line 1 has a word instead of a number") as caught:
        SurfaceFile(path=str(path))
    assert "very" not in str(caught.value)


def test_a_mesh_of_another_program_with_the_ending_of_gmsh_is_refused_at_once(tmp_path):
    pytest.importorskip("meshlane")
    path = tmp_path / "ball.msh"
    path.write_text("(10 (0 1 9 0))\n(10 (1 1 9 1 3)(\n0 0 0\n")  # whose own reader does not end where the text breaks off
    with pytest.raises(ValidationError, match=r"ball\.msh cannot be read as a surface"):
        SurfaceFile(path=str(path))
