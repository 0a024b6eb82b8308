"""Tetrahedra from files: nodes, cells and named sets come back from every format; what is no mesh of tetrahedra is named."""

import sys

import numpy as np
import pytest
from pydantic import ValidationError
from typer.testing import CliRunner

from pellucid.case.reading import loads
from pellucid.cli import app
from pellucid.errors import CaseError
from pellucid.geometry.checks.solid_checks import solid_faults
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.geometry.solid_meshes.file import SolidFile
from pellucid.geometry.solid_meshes.solid_mesh import SolidMesh

LOWER, UPPER = np.array([-1.0, 0.0, 2.0]), np.array([1.0, 3.0, 2.5])
FORMATS = {
    "gmsh 2.2": ("msh", {"file_format": "gmsh22", "binary": False}),
    "gmsh 2.2, binary": ("msh", {"file_format": "gmsh22", "binary": True}),
    "gmsh 4.1": ("msh", {"file_format": "gmsh", "binary": False}),
    "gmsh 4.1, binary": ("msh", {"file_format": "gmsh", "binary": True}),
    "vtk": ("vtk", {}),
    "vtu": ("vtu", {}),
    "abaqus": ("inp", {}),
    "nastran": ("bdf", {}),
}
CASE = """
title = "t"
time = { end = 1.0 }
[[body]]
name = "cube"
kind = "meshless-solid"
mesh = { file = { path = "FILE" } }
material = { kind = "neo-hookean", density = 1, young_modulus = 1, poisson_ratio = 0.3 }
"""
NODES = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]]
CELLS = [[0, 1, 2, 3], [1, 2, 3, 4]]
GMSH_22 = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 7 "floor"
3 9 "solid body"
$EndPhysicalNames
$Nodes
5
10 0 0 0
20 1 0 0
30 0 1 0
40 0 0 1
50 1 1 1
$EndNodes
$Elements
3
1 2 2 7 5 10 20 30
2 4 2 9 6 10 20 30 40
3 4 2 9 6 20 30 40 50
$EndElements
"""
GMSH_41 = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
2
2 7 "floor"
3 9 "solid body"
$EndPhysicalNames
$Entities
0 0 1 1
5 0 0 0 1 1 0 1 7 0
6 0 0 0 1 1 1 1 9 1 5
$EndEntities
$Nodes
2 5 1 5
2 5 0 3
1
2
3
0 0 0
1 0 0
0 1 0
3 6 0 2
4
5
0 0 1
1 1 1
$EndNodes
$Elements
2 3 1 3
2 5 2 1
1 1 2 3
3 6 4 2
2 1 2 3 4
3 2 3 4 5
$EndElements
"""
ABAQUS = """*HEADING
by hand
*NODE
 1, 0., 0., 0.
 2, 1., 0., 0.
 3, 0., 1., 0.
 4, 0., 0., 1.
 15, 1., 1., 1.
*ELEMENT, TYPE=C3D4, ELSET=EVERY
 1, 1, 2, 3, 4
 7, 2, 3, 4, 15
*NSET, NSET=FLOOR, GENERATE
 1, 3, 1
*NSET, NSET=tips
 4,
 15
*ELSET, ELSET=upper
 7
"""
SURFACES = """*ELSET, ELSET=_under_S1
 1
*Surface, type=ELEMENT, name=under
** a comment
 _UNDER_S1, S1
*SURFACE, NAME=side
 upper, S3
*SURFACE, NAME=two sides
 _under_S1, S2
 _under_S1, S4
*SURFACE, TYPE=NODE, NAME=corners
 tips, 1.
*SURFACE, NAME=by number
 7, S1
*STEP
"""
NASTRAN = """BEGIN BULK
GRID           1              0.      0.      0.
GRID           2              1.      0.      0.
GRID           3              0.      1.      0.
GRID           4              0.      0.      1.
GRID          15              1.      1.      1.
CTETRA         1       9       1       2       3       4
CTETRA         2       9       2       3       4      15
CTRIA3         3       7       1       2       3
ENDDATA
"""
EVERY, FLOOR = [0, 1, 2, 3, 4], [0, 1, 2]
BY_HAND = {
    "gmsh 2.2": ("msh", GMSH_22, {"floor": FLOOR, "solid body": EVERY}),
    "gmsh 2.2, no names": (
        "msh",
        GMSH_22[: GMSH_22.index("$PhysicalNames")] + GMSH_22[GMSH_22.index("$Nodes") :],
        {"7": FLOOR, "9": EVERY},
    ),
    "gmsh 4.1": ("msh", GMSH_41, {"floor": FLOOR, "solid body": EVERY}),
    "abaqus": ("inp", ABAQUS, {"FLOOR": FLOOR, "tips": [3, 4], "upper": [1, 2, 3, 4], "EVERY": EVERY}),
    "abaqus, surfaces": (
        "inp",
        ABAQUS + SURFACES,
        {"FLOOR": FLOOR, "tips": [3, 4], "upper": [1, 2, 3, 4], "EVERY": EVERY, "_under_S1": [0, 1, 2, 3]}
        | {"under": [0, 1, 2], "side": [2, 3, 4], "two sides": [0, 1, 2, 3], "corners": [3, 4], "by number": [1, 2, 3]},
    ),
    "nastran": ("bdf", NASTRAN, {"7": FLOOR, "9": EVERY}),
}


@pytest.fixture
def meshlane():
    return pytest.importorskip("meshlane")


@pytest.mark.parametrize("form", FORMATS)
def test_what_was_written_comes_back(meshlane, tmp_path, form):
    ending, options = FORMATS[form]
    mesh = box_mesh(LOWER, UPPER, (2, 1, 1))
    path = tmp_path / f"box.{ending}"
    meshlane.write(str(path), meshlane.Mesh(1000.0 * mesh.nodes, [("tetra", mesh.cells)]), **options)
    read = SolidFile(path=str(path), scale=0.001, offset=(0.0, 0.0, 1.0)).mesh()
    assert read.cells.tolist() == mesh.cells.tolist()
    assert read.nodes == pytest.approx(
        mesh.nodes + np.array([0.0, 0.0, 1.0]), abs=1e-9 if ending != "bdf" else 1e-5
    )  # few digits there


@pytest.mark.parametrize("form", BY_HAND)
def test_files_as_other_programs_write_them(meshlane, tmp_path, form):
    ending, text, sets = BY_HAND[form]
    path = tmp_path / f"two.{ending}"
    path.write_text(text)
    mesh = SolidFile(path=str(path)).mesh()
    assert mesh.nodes.tolist() == NODES
    assert mesh.cells.tolist() == CELLS
    assert {name: nodes.tolist() for name, nodes in mesh.sets.items()} == sets
    assert list(solid_faults(mesh)) == []


def test_named_groups_of_binary_gmsh_files(meshlane, tmp_path):
    for form, text in (("gmsh", GMSH_41), ("gmsh22", GMSH_22)):
        (tmp_path / "text.msh").write_text(text)
        binary = tmp_path / f"{form}.msh"
        meshlane.write(str(binary), meshlane.read(str(tmp_path / "text.msh")), file_format=form, binary=True)
        assert b"$Nodes" in binary.read_bytes()
        mesh = SolidFile(path=str(binary)).mesh()
        assert {name: nodes.tolist() for name, nodes in mesh.sets.items()} == {"floor": FLOOR, "solid body": EVERY}


@pytest.mark.parametrize("ending", ["vtk", "vtu", "inp"])
def test_sets_of_nodes_and_cells_are_read_back(meshlane, tmp_path, ending):
    mesh = box_mesh(LOWER, UPPER, (4, 1, 1))
    bottom, left = np.flatnonzero(mesh.nodes[:, 2] == LOWER[2]), np.flatnonzero(mesh.nodes[mesh.cells].max(axis=1)[:, 0] <= 0.0)
    path = tmp_path / f"box.{ending}"
    table = {"point_sets": {"bottom": bottom}, "cell_sets": {"left": [left]}}
    meshlane.write(str(path), meshlane.Mesh(mesh.nodes, [("tetra", mesh.cells)], **table))
    sets = SolidFile(path=str(path)).mesh().sets
    assert sets["bottom"].tolist() == bottom.tolist()
    assert sets["left"].tolist() == np.unique(mesh.cells[left]).tolist()


@pytest.mark.parametrize("ending", ["vtk", "vtu"])
def test_arrays_of_0_and_1_mark_sets_and_others_do_not(meshlane, tmp_path, ending):
    mesh = box_mesh(LOWER, UPPER, (2, 1, 1))
    top = mesh.nodes[:, 2] == UPPER[2]
    marks = {"top": top.astype(int), "number": np.arange(len(top)), "share": top.astype(float), "none": np.zeros(len(top), int)}
    path = tmp_path / f"box.{ending}"
    half = np.arange(len(mesh.cells)) < 3
    meshlane.write(
        str(path), meshlane.Mesh(mesh.nodes, [("tetra", mesh.cells)], point_data=marks, cell_data={"few": [half.astype(int)]})
    )
    sets = SolidFile(path=str(path)).mesh().sets
    assert {name: nodes.tolist() for name, nodes in sets.items()} == {
        "top": np.flatnonzero(top).tolist(),
        "few": np.unique(mesh.cells[:3]).tolist(),
    }


def test_sets_that_name_nothing_are_kept_and_told(meshlane, tmp_path):
    path = tmp_path / "two.inp"
    path.write_text(ABAQUS + "*NSET, NSET=nobody\n*NSET, NSET=joined\n FLOOR, tips\n")
    mesh = SolidFile(path=str(path)).mesh()
    assert [text for text, _ in solid_faults(mesh)] == ["1 set has no nodes: `nobody`"]
    assert mesh.sets["joined"].tolist() == EVERY, "a set may name others"
    path = tmp_path / "two.msh"
    path.write_text(GMSH_22.replace('2\n2 7 "floor"', '3\n2 8 "roof"\n2 7 "floor"'))
    with pytest.warns(UserWarning, match="two.msh: the physical groups `roof`"):
        mesh = SolidFile(path=str(path)).mesh()
    assert list(mesh.sets) == ["floor", "solid body"]
    assert list(solid_faults(mesh)) == []


def two_volumes(meshlane, path, shift):
    """A file of two boxes, meshed apart, of which the upper one stands on the lower one, moved by `shift` along x."""
    box = box_mesh(np.zeros(3), np.ones(3), (2, 2, 2))
    nodes = np.vstack([box.nodes, box.nodes + np.array([shift, 0.0, 1.0])])
    mesh = meshlane.Mesh(nodes, [("tetra", np.vstack([box.cells, box.cells + len(box.nodes)]))])
    meshlane.write(str(path), mesh, file_format="gmsh")


def test_volumes_that_were_meshed_apart_are_refused(meshlane, tmp_path):
    path = tmp_path / "two.msh"
    two_volumes(meshlane, path, 0.0)
    with pytest.warns(UserWarning, match="two.msh: the mesh consists of 2 pieces"), pytest.raises(CaseError) as error:
        loads(CASE.replace("FILE", str(path)))
    [problem] = error.value.problems
    assert problem.key == "body.cube.mesh"
    assert problem.text.startswith(f"{path}: 9 pairs of nodes have the same position, for example numbers ")
    assert "merge these nodes (in Gmsh: Coherence" in problem.remedy


def test_pieces_of_a_mesh_are_warned_of_once(meshlane, tmp_path):
    path = tmp_path / "two.msh"
    two_volumes(meshlane, path, 0.1)
    file = tmp_path / "case.toml"
    file.write_text(CASE.replace("FILE", str(path)))
    result = CliRunner().invoke(app, ["validate", str(file)])
    assert result.exit_code == 0
    text = f"warning: {path}: the mesh consists of 2 pieces that share no node, of 96 and 96 tetrahedra; no force acts"
    assert result.output.count(text) == 1
    assert result.output.count("warning: ") == 1


def test_a_mesh_is_made_once_while_its_file_does_not_change(meshlane, tmp_path):
    path = tmp_path / "box.vtk"
    for n in (1, 2):
        box = box_mesh(LOWER, UPPER, (n, n, n))
        meshlane.write(str(path), meshlane.Mesh(box.nodes, [("tetra", box.cells)]))
        source = SolidMesh(file={"path": str(path)})
        assert len(source.mesh().cells) == len(box.cells)
        assert source.mesh() is SolidMesh(file={"path": str(path)}).mesh()
    table = {"lower": LOWER.tolist(), "upper": UPPER.tolist(), "cells": (1, 2, 3)}
    assert SolidMesh(box=table).mesh() is SolidMesh(box=table).mesh()


def test_files_that_are_no_mesh_of_tetrahedra_are_refused(meshlane, tmp_path):
    sheet = tmp_path / "sheet.vtk"
    meshlane.write(str(sheet), meshlane.Mesh(np.eye(3), [("triangle", np.array([[0, 1, 2]]))]))
    with pytest.raises(ValidationError, match=r"other solid elements; .* fill a closed surface by `mesh = \{ inside = "):
        SolidFile(path=str(sheet))
    with pytest.raises(
        ValidationError, match=r"there is no file .*; a relative path is relative to the folder of the case file"
    ):
        SolidFile(path=str(tmp_path / "none.msh"))
    with pytest.raises(ValidationError, match=r"did you mean `sheet\.vtk`"):
        SolidFile(path=str(tmp_path / "sheat.vtk"))
    for name, why in (("poem.txt", "the file name ending .txt is not known"), ("poem", "its file name has no ending")):
        (tmp_path / name).write_text("a poem")
        with pytest.raises(ValidationError, match=rf"{name} cannot be read as a mesh: {why}; save it as one of Gmsh"):
            SolidFile(path=str(tmp_path / name))
    (tmp_path / "poem.msh").write_text("a poem")
    with pytest.raises(ValidationError, match=r"poem.msh cannot be read as a mesh"):
        SolidFile(path=str(tmp_path / "poem.msh"))


@pytest.mark.parametrize(
    ("name", "text", "reason"),
    [
        ("poem.msh", "a poem", "it does not follow the .msh format of Gmsh"),
        ("foo.vtk", "# vtk DataFile Version 3.0\nx\nASCII\nDATASET FOO\n", "not FOO"),
        (
            "cut.msh",
            "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 2\n",
            "its section $Nodes has no end: the line $EndNodes is missing",
        ),
        ("poem.abc", "a poem", "the file name ending .abc is not known"),
    ],
)
def test_a_file_that_cannot_be_read_is_one_finding_and_nothing_else_is_printed(name, text, reason, tmp_path, capfd):
    (tmp_path / name).write_text(text)
    with pytest.raises(CaseError) as error:
        loads(CASE.replace("FILE", str(tmp_path / name)))
    assert capfd.readouterr() == ("", "")
    [problem] = error.value.problems
    assert problem.key == "body.cube.mesh.file"
    assert problem.text.startswith(f"{tmp_path / name} cannot be read as a mesh: ")
    assert reason in problem.text
    again = "" if name == "poem.abc" else "write the file again with the program that made it, or "
    assert problem.remedy == f"{again}save it as one of Gmsh (.msh), VTK (.vtk, .vtu), Abaqus (.inp), Nastran (.bdf, .nas)"


def test_without_meshlane_the_extra_is_named(tmp_path, monkeypatch):
    (tmp_path / "a.bdf").write_text("GRID")
    monkeypatch.setitem(sys.modules, "meshlane", None)
    with pytest.raises(ValueError, match=r"meshlane, which .* is not installed; .*pip.* install '\.\[mesh\]' in the clone"):
        SolidFile(path=str(tmp_path / "a.bdf"))


@pytest.mark.parametrize(
    ("kind", "corners", "faces"),
    [
        ("C3D8", 8, ["1 2 3 4", "5 6 7 8", "1 2 5 6", "2 3 6 7", "3 4 7 8", "1 4 5 8"]),
        ("C3D6", 6, ["1 2 3", "4 5 6", "1 2 4 5", "2 3 5 6", "1 3 4 6"]),
    ],
)
def test_faces_of_bricks_and_wedges_that_abaqus_names(meshlane, tmp_path, kind, corners, faces):
    """Abaqus Analysis User's Guide, three-dimensional solid element library, element faces."""
    places = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]
    if corners == 6:
        places = [*places[:3], *places[4:7]]
    lines = ["*NODE", *(f"{k}, {x}, {y}, {z}" for k, (x, y, z) in enumerate(places, 1))]
    lines += [f"*ELEMENT, TYPE={kind}, ELSET=all", ", ".join(map(str, [1, *range(1, corners + 1)]))]
    for number in range(1, len(faces) + 1):
        lines += [f"*SURFACE, NAME=side{number}, TYPE=ELEMENT", f"all, S{number}"]
    (tmp_path / "a.inp").write_text("\n".join([*lines, ""]))
    with pytest.warns(UserWarning, match="was divided into"):
        mesh = SolidFile(path=str(tmp_path / "a.inp")).mesh()
    for number, named in enumerate(faces, 1):
        assert (mesh.sets[f"side{number}"] + 1).tolist() == [int(word) for word in named.split()]
