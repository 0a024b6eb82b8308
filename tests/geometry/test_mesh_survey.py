"""What is told of a file of a mesh."""

import numpy as np
import pytest

from pellucid.geometry.files.writing import write_solid, write_surface
from pellucid.geometry.mesh_survey import survey
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.geometry.surfaces.quadrilaterals import BoxSurface
from pellucid.geometry.surfaces.triangles import Icosphere

CUBE = BoxSurface(lower=(0, 0, 0), upper=(40, 20, 10), points=(5, 3, 2)).mesh()


def rows(path, metres=1.0):
    return dict(survey(str(path), False, 0, metres).rows)


def test_a_closed_surface(tmp_path):
    write_surface(tmp_path / "a.obj", ".obj", *CUBE)
    told = rows(tmp_path / "a.obj", 1e-3)
    assert told["format"] == "OBJ, text"
    assert told["elements"] == f"{len(CUBE.quads)} quadrilaterals"
    assert told["extent"] == "0.04 x 0.02 x 0.01 m, from (0, 0, 0) to (0.04, 0.02, 0.01) m"
    assert told["volume"] == "8e-06 m^3"
    assert told["area"] == "0.0028 m^2"
    assert told["closed"] == "yes"
    assert told["quality"].startswith("lowest 1, near (")
    assert told["edges"].startswith("shortest 0.01 m")
    assert told["orientation"] == "consistent, normals outward"


@pytest.mark.parametrize(
    ("factor", "guess"),
    [(0.001, "usually in metres"), (1.0, "an extent of 40 is probably in mm or um"), (50.0, "2e+03 is probably in um")],
)
def test_the_unit_is_guessed_and_said_to_be_a_guess(tmp_path, factor, guess):
    write_surface(tmp_path / "a.obj", ".obj", factor * CUBE.vertices, *CUBE[1:])
    unit = rows(tmp_path / "a.obj")["unit"]
    assert unit.startswith("the file does not define its unit; ")
    assert guess in unit


def test_a_unit_that_the_file_says_is_told(tmp_path):
    write_surface(tmp_path / "a.obj", ".obj", *CUBE)
    (tmp_path / "a.obj").write_text("# Units: mm\n" + (tmp_path / "a.obj").read_text())
    assert rows(tmp_path / "a.obj")["unit"].startswith("the file defines mm")


def test_holes_pieces_and_crossings(tmp_path):
    one, n = CUBE, len(CUBE.vertices)
    write_surface(tmp_path / "a.ply", ".ply", one.vertices, one.quads[1:], one.triangles)
    assert rows(tmp_path / "a.ply")["closed"].startswith("no: 1 rim or hole with 4 edges; the smallest is near (")
    two = np.concatenate([one.vertices, one.vertices + np.array([3.3, 4.4, 5.5])])
    write_surface(tmp_path / "b.ply", ".ply", two, np.concatenate([one.quads, one.quads + n]), one.triangles)
    found = survey(str(tmp_path / "b.ply"), False, 0, 1.0)
    assert dict(found.rows)["pieces"] == "2"
    [(text, _)] = found.faults
    assert text.startswith("the surface intersects itself near (")


def test_a_solid_with_its_sets(tmp_path):
    pytest.importorskip("meshlane")
    box = box_mesh(np.zeros(3), np.ones(3), (2, 2, 2))
    write_solid(tmp_path / "a.inp", ".inp", box.nodes, box.cells, {"floor": np.flatnonzero(box.nodes[:, 2] == 0.0)})
    told = rows(tmp_path / "a.inp")
    assert told["sets"] == "`floor` (9 nodes)"
    assert told["elements"] == f"{len(box.cells)} tetrahedra"
    assert told["volume"] == "1 m^3"
    assert told["pieces"] == "1"
    assert "degrees between faces" in told["angles"]


def test_the_worst_element_is_placed(tmp_path):
    ball = Icosphere(centre=(0, 0, 0), radius=1.0, refinements=2).mesh()
    vertices = ball.vertices.copy()
    vertices[ball.triangles[7, 0]] = 0.98 * vertices[ball.triangles[7, 1]] + 0.02 * vertices[ball.triangles[7, 0]]
    write_surface(tmp_path / "a.stl", ".stl", vertices, ball.quads, ball.triangles)
    place = vertices[ball.triangles[7, 1]]
    near = rows(tmp_path / "a.stl")["edges"].split("near (")[1].split(")")[0]
    assert np.allclose([float(x) for x in near.split(",")], place, atol=0.02)
