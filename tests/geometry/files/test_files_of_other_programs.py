"""Small files in the manner of programs that people use: each is read, or refused in a sentence that can be followed."""

import struct
import zipfile
from io import BytesIO

import numpy as np
import pytest
from abaqus_files import CAE, ELEMENTS, NODES
from gmsh_files import gmsh_file

from pellucid.findings import Refusal
from pellucid.geometry.files.surface_formats import FACET
from pellucid.geometry.mesh_survey import survey
from pellucid.geometry.surfaces.quadrilaterals import BoxSurface

CUBE = BoxSurface(lower=(0, 0, 0), upper=(2, 2, 2), points=(2, 2, 2)).mesh()
QUADS, TRIANGLES = CUBE.quads, CUBE.triangulated().triangles
AXES = "property float x\nproperty float y\nproperty float z\n"


def facets(form="{:e}", normal="0 0 1", indent="  ", end="\n"):
    lines = []
    for corners in CUBE.vertices[TRIANGLES]:
        lines += [f"{indent}facet normal {normal}", f"{indent}{indent}outer loop"]
        lines += [f"{3 * indent}vertex " + " ".join(form.format(x) for x in place) for place in corners]
        lines += [f"{indent}{indent}endloop", f"{indent}endfacet"]
    return end.join([*lines, ""])


def text_stl(name, **how):
    end = how.get("end", "\n")
    return f"solid {name}{end}{facets(**how)}endsolid {name}{end}".encode()


def binary_stl(header, attribute=0, count=None, behind=b""):
    table = np.zeros(len(TRIANGLES), FACET)
    table["corners"], table["attribute"] = CUBE.vertices[TRIANGLES], attribute
    return header.ljust(80, b" ") + np.uint32(len(table) if count is None else count).tobytes() + table.tobytes() + behind


def obj(head="", corner="{v}", elements=QUADS, tail="", end="\n"):
    lines = [head] if head else []
    lines += ["v " + " ".join(f"{x:.6f}" for x in place) for place in CUBE.vertices]
    lines += ["f " + " ".join(corner.format(v=v + 1) for v in corners) for corners in elements]
    return end.join([*lines, tail, ""]).encode()


def split_ply(order="<", name="vertex_indices"):
    """Every face with vertices of its own, as texture seams make them, with normals and coordinates of textures."""
    head = f"ply\nformat binary_{'little' if order == '<' else 'big'}_endian 1.0\ncomment Created in Blender version 4.1\n"
    head += f"element vertex {4 * len(QUADS)}\n{AXES}property float nx\nproperty float ny\nproperty float nz\n"
    head += f"property float s\nproperty float t\nelement face {len(QUADS)}\nproperty list uchar uint {name}\nend_header\n"
    rows = b"".join(np.array([*place, 0, 0, 1, 0, 0], f"{order}f4").tobytes() for place in CUBE.vertices[QUADS].reshape(-1, 3))
    faces = b"".join(b"\x04" + np.arange(4 * k, 4 * k + 4, dtype=f"{order}u4").tobytes() for k in range(len(QUADS)))
    return head.encode() + rows + faces


def meshlab_ply(end="\n", faces=True):
    n = len(TRIANGLES) if faces else 0
    head = f"ply\nformat ascii 1.0\ncomment VCGLIB generated\nelement vertex {len(CUBE.vertices)}\n{AXES}property uchar red\n"
    head += (
        f"property float quality\nelement face {n}\nproperty list uchar int vertex_indices\nproperty int flags\nend_header\n"
    )
    rows = [f"{x:g} {y:g} {z:g} 255 0.5" for x, y, z in CUBE.vertices]
    rows += [f"3 {a} {b} {c} 7" for a, b, c in TRIANGLES[:n]]
    return (head + "\n".join([*rows, ""])).replace("\n", end).encode()


def vtk_51(kind, binary):
    """A cube of VTK's kinds of cells: a voxel, or a hexahedron, as version 5.1 writes a grid."""
    places = [(x, y, z) for z in (0, 2) for y in (0, 2) for x in (0, 2)]
    corners = list(range(8)) if kind == 11 else [0, 1, 3, 2, 4, 5, 7, 6]

    def values(numbers, code):
        return (
            struct.pack(f">{len(numbers)}{code}", *numbers) + b"\n"
            if binary
            else (" ".join(map(str, numbers)) + "\n\n").encode()
        )

    form = "BINARY" if binary else "ASCII"
    head = f"# vtk DataFile Version 5.1\nvtk output\n{form}\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n"
    data = head.encode() + values([x for place in places for x in place], "f")
    data += (
        b"METADATA\nINFORMATION 0\n\nCELLS 2 8\nOFFSETS vtktypeint64\n" + values([0, 8], "q") + b"CONNECTIVITY vtktypeint64\n"
    )
    data += values(corners, "q") + b"CELL_TYPES 1\n" + values([kind], "i") + b"\nPOINT_DATA 8\nVECTORS u float\n"
    data += values([0] * 24, "f") + b"SCALARS c double\nLOOKUP_TABLE default\n" + values([0] * 8, "d") + b"FIELD FieldData 2\n"
    data += b"pair 2 8 double\n" + values([0] * 16, "d") + b"left%20face 1 8 int\n" + values([1, 0] * 4, "i")
    return data


def zipped():
    data = BytesIO()
    with zipfile.ZipFile(data, "w") as file:
        file.writestr("3D/3dmodel.model", "<model/>" * 100)
    return data.getvalue()


def off(head="OFF", row=" 255 0 0 255", tail=" 3 255 0 0"):
    lines = [f"{head} {len(CUBE.vertices)} {len(QUADS)} 12"]
    lines += [" ".join(map(str, place)) + row for place in CUBE.vertices]
    lines += [f"4 {a} {b} {c} {d}{tail}" for a, b, c, d in QUADS]
    return "\n".join([*lines, ""]).encode()


def medit(count="\n"):
    """A cube with marks of a remesher: corners, ridges, required elements, normals; count: what stands before a count."""
    lines = ["MeshVersionFormatted 3" if count == " " else "MeshVersionFormatted 2", "", f"Dimension{count}3", ""]
    lines += [f"Vertices{count}{len(CUBE.vertices)}", *(" ".join(map(str, [*place, 0])) for place in CUBE.vertices), ""]
    lines += [f"Corners{count}2", "1", "2", f"RequiredVertices{count}1", "3", f"Ridges{count}1", "1", "# faces"]
    lines += [f"Triangles{count}{len(TRIANGLES)}", *(f"{a} {b} {c} 1" for a, b, c in TRIANGLES + 1)]
    lines += [f"RequiredTriangles{count}1", "2", f"Normals{count}1", "0 0 1", f"NormalAtVertices{count}1", "1 1", "", "End", ""]
    return "\n".join(lines).encode()


def nastran(case=str):
    lines = ["$ cube", *(f"GRID,{k + 1},,{x},{y},{z}" for k, (x, y, z) in enumerate(CUBE.vertices))]
    lines += [f"CTRIA3,{k + 1},1,{a},{b},{c}" for k, (a, b, c) in enumerate(TRIANGLES + 1)]
    return "\n".join([*map(case, lines), case("ENDDATA"), ""]).encode()


HYPERMESH = "**\n** ABAQUS Input Deck Generated by HyperMesh\n**\n*NODE\n" + NODES.split("\n", 1)[1]
HYPERMESH += "**HWCOLOR COMP 1 3\n*ELEMENT,TYPE=C3D4,ELSET=auto1\n" + ELEMENTS.split("\n", 1)[1] + "**HM_set_by_property\n"
READ = {
    "fusion.stl": (text_stl("ASCII", form="{:.6f}"), 8.0),
    "fusion-binary.stl": (binary_stl(b"STLB ATF 13.2.0.100 COLOR=\xa0\xa0\xa0\xff"), 8.0),
    "solidworks.stl": (text_stl("Part1", form="{:.6E}", indent="\t", end="\r\n"), 8.0),
    "openscad.stl": (text_stl("OpenSCAD_Model", form="{:g}"), 8.0),
    "meshlab.stl": (text_stl("vcg", normal="nan nan nan"), 8.0),
    "magics.stl": (binary_stl(b"COLOR=\x00\x00\x00\xffMATERIAL=", attribute=0x7C00), 8.0),
    "old-mac.stl": (text_stl("a", end="\r"), 8.0),
    "SHOUTED.STL": (text_stl("a").upper(), 8.0),
    "no-name.stl": (b"solid\n" + facets().encode() + b"endsolid", 8.0),
    "rhino.stl": (b"; Rhinoceros\n" + text_stl("OBJECT"), 8.0),
    "powershell.stl": (text_stl("a").decode().encode("utf-16"), 8.0),
    "streamed.stl": (binary_stl(b"numpy-stl", count=0), 8.0),
    "trailing.stl": (binary_stl(b"exporter", behind=b"\0" * 512), 8.0),
    "blender.obj": (
        obj("# Blender\nmtllib a.mtl\no Cube\nvn 0 0 1\nvt 0 0", "{v}/1/1", tail="s 1\nusemtl Material"),
        8.0,
    ),
    "maya.obj": (obj("# maya\ng default", "{v}//1", tail="vn 0 0 1"), 8.0),
    "rhino.obj": (obj("# Rhino\n", "{v} \\\n", end="\r\n"), 8.0),
    "notepad.obj": (b"\xef\xbb\xbf" + obj("# saved with a mark"), 8.0),
    "blender.ply": (split_ply(), 8.0),
    "big-endian.ply": (split_ply(">", "vertex_index"), 8.0),
    "meshlab.ply": (meshlab_ply(), 8.0),
    "windows.ply": (meshlab_ply(end="\r\n"), 8.0),
    "old-mac.ply": (meshlab_ply(end="\r"), 8.0),
    "meshlab.off": (off("COFF"), 8.0),
    "modelnet.off": (off(row="", tail="").replace(b"OFF ", b"OFF"), 8.0),
    "mmg.mesh": (medit(), 8.0),
    "mmg-3.mesh": (medit(" "), 8.0),
    "lower.nas": (nastran(str.lower), 8.0),
    "paraview-text.vtk": (vtk_51(12, False), 8.0),
    "paraview.vtk": (vtk_51(12, True), 8.0),
    "voxels.vtk": (vtk_51(11, True), 8.0),
    "gmsh-2.2.msh": (gmsh_file("2.2"), 1.0),
    "gmsh-4.1.msh": (gmsh_file("4.1", binary=True, parametric=True), 1.0),
    "hypermesh.inp": (HYPERMESH.encode(), 1.0),
    "cae.inp": (CAE.encode(), 2.0),
    "windows.inp": ((NODES + ELEMENTS + "*NSET, NSET=Außen\n1\n").replace("\n", "\r\n").encode("cp1252"), 1.0),
}
FAULTY = {
    "comma.stl": (
        text_stl("a", form="{:.1f}").replace(b".0", b",0"),
        "line 4 has `0,0`, with a decimal comma, instead of a number",
    ),
    "page.stl": (b"<!DOCTYPE html>\n<html>not found</html>\n" * 9, "it is truncated, or not an STL file"),
    "page-short.stl": (b"<!DOCTYPE html>\n", "it is not text with `facet` and `vertex` lines, and shorter than the header"),
    "model.3mf": (zipped(), "the file name ending .3mf is not known"),
    "renamed.stl": (zipped(), "it is truncated, or not an STL file"),
    "cut.stl": (binary_stl(b"exporter")[:-70], "its header states 12 facets, but 10 follow: it is truncated"),
    "cloud.ply": (meshlab_ply(faces=False), "contains no triangles or quadrilaterals: it has 8 points and no elements"),
    "patch.obj": (b"v 0 0 0\ncstype bspline\ndeg 3 3\n", "line 2 has a free-form curve or surface: write it as triangles"),
    "old.msh": (gmsh_file("4.1").replace(b"4.1 0 8", b"3.0 0 8"), "write it with `Mesh.MshFileVersion = 4.1`"),
    "fluent.msh": (b'(0 "GAMBIT to Fluent File")\n(0 "Dimension:")\n(2 3)\n', "it does not follow the .msh format of Gmsh"),
    "alone.inp": (
        b"*INCLUDE, INPUT=mesh.inp\n",
        "line 1 includes mesh.inp, but there is no such file in the folder of alone.inp",
    ),
    "polyhedra.vtk": (vtk_51(42, True), "contains cells of type polyhedron; a surface may only have triangles"),
    "short.vtk": (vtk_51(13, False), "a cell of type 13 has 8 points, but needs 6"),
}


@pytest.mark.parametrize("name", READ)
def test_sound_files_are_read(name, tmp_path):
    data, volume = READ[name]
    path = tmp_path / name
    path.write_bytes(data)
    found = survey(str(path), False, 0, 1.0)
    assert found.faults == []
    assert float(dict(found.rows)["volume"].split()[0]) == pytest.approx(volume)


@pytest.mark.parametrize("name", FAULTY)
def test_faulty_files_are_refused_in_a_sentence(name, tmp_path):
    data, reason = FAULTY[name]
    path = tmp_path / name
    path.write_bytes(data)
    with pytest.raises(Refusal) as refusal:
        survey(str(path), False, 0, 1.0)
    assert name in refusal.value.reason.text
    assert reason in refusal.value.reason.text
    assert refusal.value.reason.remedy


def test_sets_of_a_grid_that_arrays_behind_others_mark(tmp_path):
    path = tmp_path / "a.vtk"
    for binary in (False, True):
        path.write_bytes(vtk_51(11, binary))
        assert ("sets", "`left face` (4 nodes)") in survey(str(path), False, 0, 1.0).rows
    grid = vtk_51(12, False).replace(
        b"POINT_DATA", b"CELL_DATA 1\nSCALARS gmsh:physical int\nLOOKUP_TABLE default\n7\nPOINT_DATA"
    )
    path.write_bytes(grid)
    assert ("sets", "`left face` (4 nodes), `7` (1 elements)") in survey(str(path), False, 0, 1.0).rows
    path.write_bytes(vtk_51(12, True)[:-10])
    found = survey(str(path), False, 0, 1.0)
    assert "some of its arrays were not read, so sets defined by these arrays are missing" in found.notes
