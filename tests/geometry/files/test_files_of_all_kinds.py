"""Files of meshes as people have them, sound and faulty: each is read, mended, or refused in a sentence to follow."""

import warnings

import numpy as np
import pytest
from typer.testing import CliRunner

from pellucid.cli import app
from pellucid.geometry.checks.surface_checks import mesh_faults
from pellucid.geometry.files.writing import write_solid, write_surface
from pellucid.geometry.meshes.enclosure import signed_volume
from pellucid.geometry.meshes.surface_mesh import NO_QUADS, Mesh
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.geometry.solid_meshes.solid_mesh import SolidMesh
from pellucid.geometry.surfaces.quadrilaterals import BoxSurface
from pellucid.geometry.surfaces.surface import Surface

CUBE = BoxSurface(lower=(0, 0, 0), upper=(50, 50, 50), points=(3, 3, 3)).mesh()
TRIANGLES = CUBE.triangulated().triangles
BLOCK = box_mesh(np.zeros(3), np.array([0.3, 0.2, 0.1]), (3, 2, 1))
REPAIR = "`repair = true`"


def stl(triangles=TRIANGLES, vertices=CUBE.vertices, **words):
    def write(path):
        write_surface(path, ".stl", vertices, NO_QUADS, np.asarray(triangles))
        text = path.read_text()
        for old, new in words.items():
            text = text.replace(old, new)
        path.write_text(text)

    return write


def surface(mesh):
    return lambda path: write_surface(path, path.suffix, *mesh)


def text(content):
    return lambda path: path.write_text(content)


def solid(cells=BLOCK.cells, nodes=BLOCK.nodes, kind="tetra", form="gmsh22", sets=None):
    def write(path):
        meshlane = pytest.importorskip("meshlane")
        mesh = meshlane.Mesh(nodes, [(kind, np.asarray(cells))], point_sets=sets or {})
        meshlane.write(str(path), mesh, file_format=form)

    return write


def turned(elements, which):
    elements = elements.copy()
    elements[which] = elements[which][:, [1, 0, *range(2, elements.shape[1])]]
    return elements


def obj_with_normals(path):
    faces = "\n".join("f " + " ".join(f"{k + 1}//1" for k in corners) for corners in CUBE.quads.tolist())
    vertices = "\n".join("v " + " ".join(map(str, place)) + " 1 0.5 0" for place in CUBE.vertices.tolist())
    path.write_text(f"# Blender\no cube\n{vertices}\nvn 0 0 1\n{faces}\n")


def obj_from_the_end(path):
    n = len(CUBE.vertices)
    faces = "\n".join("f " + " ".join(f"{k - n}/1/1" for k in corners) for corners in CUBE.quads.tolist())
    vertices = "\n".join("v " + " ".join(map(str, place)) for place in CUBE.vertices.tolist())
    path.write_text(f"{vertices}\nvt 0 0\nvn 0 0 1\n{faces}\n")


HOLED = np.delete(TRIANGLES, 0, axis=0)
SURFACES = {
    "text.stl": stl(),
    "end-loop.stl": stl(endloop="end loop", endfacet="end facet"),
    "binary.stl": lambda path: pytest.importorskip("meshlane").write_points_cells(
        path, CUBE.vertices, [("triangle", TRIANGLES)], binary=True
    ),
    "normals-and-colours.obj": obj_with_normals,
    "from-the-end.obj": obj_from_the_end,
    "quadrilaterals.ply": surface(CUBE),
    "surface.msh": surface(CUBE),
    "surface.vtu": surface(CUBE),
}
"""Sound surfaces of a cube."""
MENDED = {
    "turned.stl": (stl(turned(TRIANGLES, [0, 7, 20])), "have opposite normals at 9 edges"),
    "inward.stl": (stl(TRIANGLES[:, ::-1]), "the normals point inward"),
    "doubled.stl": (stl([*TRIANGLES, TRIANGLES[5]]), "1 triangle occurs twice"),
    "holed.stl": (stl(HOLED), "has 1 hole with 3 edges in total"),
    "needle.obj": (
        surface(CUBE._replace(triangles=np.array([(0, 0, 1)]))),
        "1 element has no area; the first is number 24",
    ),
    "lone.ply": (
        surface(CUBE._replace(vertices=np.vstack([CUBE.vertices, (9, 9, 9)]))),
        "1 vertex belongs to no quadri",
    ),
}
"""Surfaces with a fault that the repair mends, and the fault."""
BRICKS = np.array([[0, 1, 3, 2, 4, 5, 7, 6]])
CORNERS = np.stack(np.meshgrid([0, 0.3], [0, 0.2], [0, 0.1], indexing="ij"), axis=-1).reshape(-1, 3)[[0, 4, 2, 6, 1, 5, 3, 7]]
HALVES = np.concatenate([BLOCK.cells, BLOCK.cells + len(BLOCK.nodes)])
TEN = np.array([[0, 1, 2, 3, 4, 5, 6, 7, 8, 9]])
SOLIDS = {
    "all-turned.msh": (solid(turned(BLOCK.cells, np.arange(len(BLOCK.cells)))), "all of 72 tetrahedra were inverted"),
    "some-turned.vtk": (solid(turned(BLOCK.cells, [3, 40]), form="vtk"), "2 of 72 tetrahedra were inverted"),
    "bricks.inp": (solid(BRICKS, CORNERS, "hexahedron", "abaqus"), "1 hexahedron was divided into 6 tetrahedra"),
    "bricks.vtu": (solid(BRICKS, CORNERS, "hexahedron", "vtu"), "1 hexahedron was divided into 6 tetrahedra"),
}
"""Solids that are read with a warning."""
REFUSED = {
    "cut.stl": (
        text("solid a\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n"),
        "it ends within a facet, in line 4",
    ),
    "poem.obj": (text("a poem\n"), "contains no triangles or quadrilaterals"),
    "far.obj": (text("v 0 0 0\nv 1 0 0\nv 0 nan 0\nf 1 2 3\n"), "point 2 (counted from 0) is at (0, nan, 0)"),
    "empty.ply": (text("\n"), "it is empty"),
    "flap.obj": (text("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n"), "has a corner that is not one of the 3 points of the file"),
    "model.step": (text("ISO-10303-21;\n"), "the file name ending .step is not known"),
    "volume.vtk": (solid(form="vtk"), "contains cells of type tetra; a surface may only have triangles and quadrilaterals"),
}
"""Files that no repair makes a surface of, and why."""


@pytest.mark.parametrize("name", SURFACES)
def test_sound_surfaces_are_read_without_a_word(name, tmp_path):
    if not name.endswith((".stl", ".obj", ".ply")):
        pytest.importorskip("meshlane")
    path = tmp_path / name
    SURFACES[name](path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = Surface(file={"path": str(path), "unit": "mm", "closed": True})
    mesh = found.mesh()
    assert list(mesh_faults(mesh, closed=True)) == []
    assert signed_volume(*mesh.triangulated()) == pytest.approx(1.25e-4, rel=1e-12)
    assert len(mesh.vertices) == len(CUBE.vertices)
    assert len(mesh.quads) == (0 if name.endswith(".stl") else len(CUBE.quads))


@pytest.mark.parametrize("name", MENDED)
def test_faulty_surfaces_are_mended_where_that_is_asked(name, tmp_path):
    write, fault = MENDED[name]
    path = tmp_path / name
    write(path)
    file = {"path": str(path), "closed": True}
    (text, remedy), *_ = mesh_faults(Surface(file=file).mesh(), closed=True)
    assert fault in text
    assert REPAIR in remedy
    more = {"close_holes": 3} if "close_holes = 3" in remedy else {}
    with pytest.warns(UserWarning, match=rf"{name}: "):
        mended = Surface(file=file | {"repair": True} | more).mesh()
    assert list(mesh_faults(mended, closed=True)) == []
    assert signed_volume(*mended.triangulated()) == pytest.approx(125_000, rel=1e-12)
    # the command says the same, and what it writes is sound
    new = tmp_path / "new.ply"
    options = ["--repair", "--out", str(new), *(["--close-holes", "3"] if more else [])]
    assert CliRunner().invoke(app, ["mesh", str(path), *options]).exit_code == 0
    assert list(mesh_faults(Surface(file={"path": str(new)}).mesh(), closed=True)) == []


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_of_other_elements_and_turns_are_read_with_a_warning(name, tmp_path):
    write, told = SOLIDS[name]
    path = tmp_path / name
    write(path)
    with pytest.warns(UserWarning, match=rf"{name}: {told}"):
        found = SolidMesh(file={"path": str(path)})
    assert list(found.faults()) == []
    assert found.mesh().volumes.sum() == pytest.approx(0.006, rel=1e-12)


def test_tetrahedra_of_second_order_are_read_for_their_corners(tmp_path):
    tetrahedron = np.array([(0.0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)])
    between = [0.5 * (tetrahedron[a] + tetrahedron[b]) for a, b in ((0, 1), (1, 2), (0, 2), (0, 3), (1, 3), (2, 3))]
    path = tmp_path / "second.vtu"
    solid(TEN, np.vstack([tetrahedron, between]), "tetra10", "vtu")(path)
    with pytest.warns(UserWarning, match=r"1 tetrahedron of higher order \(tetra10\) was reduced .*; 6 nodes between corners"):
        mesh = SolidMesh(file={"path": str(path)}).mesh()
    assert np.array_equal(mesh.nodes, tetrahedron)


def test_a_solid_of_two_parts_meshed_apart_is_merged(tmp_path):
    path = tmp_path / "two.vtu"
    above = BLOCK.nodes + np.array([0, 0, 0.1 + 1e-12])
    solid(HALVES, np.vstack([BLOCK.nodes, above]), form="vtu")(path)
    file = {"path": str(path)}
    with pytest.warns(UserWarning, match="2 pieces"):
        [(text, remedy)] = SolidMesh(file=file).faults()
    assert "pairs of nodes have the same position" in text
    assert REPAIR in remedy
    with pytest.warns(UserWarning, match="12 nodes were merged"):
        found = SolidMesh(file=file | {"repair": True})
    assert list(found.faults()) == []
    assert found.mesh().volumes.sum() == pytest.approx(0.012)
    assert len(found.mesh().nodes) == 2 * len(BLOCK.nodes) - 12


def test_doubled_and_lone_parts_of_a_solid_are_left_out(tmp_path):
    path = tmp_path / "crowd.msh"
    solid([*BLOCK.cells, BLOCK.cells[4]], np.vstack([BLOCK.nodes, (9, 9, 9)]))(path)
    texts = [text for text, _ in SolidMesh(file={"path": str(path)}).faults()]
    assert ["belongs to no tetrahedron" in text or "occurs twice" in text for text in texts] == [True, True]
    with pytest.warns(UserWarning, match="removed") as told:
        found = SolidMesh(file={"path": str(path), "repair": True})
    assert "1 duplicate tetrahedron was removed, the first at (" in str(told[0].message)
    assert "1 unused node was removed, the first at (9, 9, 9)" in str(told[1].message)
    assert list(found.faults()) == []
    assert np.array_equal(found.mesh().cells, BLOCK.cells)


def test_tetrahedra_that_overlap_stay_an_error(tmp_path):
    path = tmp_path / "tangled.msh"
    nodes = BLOCK.nodes.copy()
    inner = np.argmin(np.linalg.norm(nodes - nodes.mean(axis=0), axis=1))
    nodes[inner] += np.array([0.35, 0.0, 0.0])
    write_solid(path, ".msh", nodes, BLOCK.cells, {})
    for repair in (False, True):
        with pytest.warns(UserWarning, match="tetrahedra were inverted"):
            found = SolidMesh(file={"path": str(path), "repair": repair})
        [(text, remedy)] = found.faults()
        assert "on the same side of a shared face" in text
        assert "mesh this part again" in remedy


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_no_surface_is_refused_with_a_remedy(name, tmp_path):
    write, why = REFUSED[name]
    path = tmp_path / name
    write(path)
    for repair in (False, True):
        with pytest.raises(ValueError, match="; ") as error:
            Surface(file={"path": str(path), "repair": repair})
        [problem] = error.value.errors()
        reason = problem["ctx"]["error"].reason
        assert why in reason.text
        assert any(verb in reason.remedy for verb in ("save", "leave"))
        assert name in reason.text


def test_a_surface_that_is_no_solid_says_how_it_is_filled(tmp_path):
    write_surface(tmp_path / "cube.vtu", ".vtu", *Mesh(CUBE.vertices, CUBE.quads))
    with pytest.raises(ValueError, match=r"other solid elements; .* fill a closed surface by `mesh = \{ inside ="):
        SolidMesh(file={"path": str(tmp_path / "cube.vtu")})
