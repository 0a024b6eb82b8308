"""Coordinates too coarse for the edges of a mesh are warned of, and others are not."""

import numpy as np
import pytest
from vtp_files import vtp

from pellucid.geometry.files.ply import read_ply
from pellucid.geometry.files.read import ANY, precision_notes, read_file
from pellucid.geometry.files.surface_formats import FACET
from pellucid.geometry.files.vtk_legacy import read_grid
from pellucid.geometry.files.writing import write_surface
from pellucid.geometry.meshes.surface_mesh import NO_QUADS
from pellucid.geometry.surfaces.quadrilaterals import BoxSurface
from pellucid.geometry.surfaces.surface import Surface

CUBE = BoxSurface(lower=(0, 0, 0), upper=(1, 1, 1), points=(3, 3, 3)).mesh().triangulated()
UTM = np.array([400_000.0, 5_800_000.0, 30.0])


def binary_stl(path, places):
    facets = np.zeros(len(CUBE.triangles), FACET)
    facets["corners"] = places[CUBE.triangles]
    path.write_bytes(b"scan".ljust(80) + np.uint32(len(facets)).tobytes() + facets.tobytes())


def scientific_stl(path, places):
    lines = ["solid a"]
    for corners in places[CUBE.triangles]:
        lines += ["facet normal 0 0 1", "outer loop", *(f"vertex {x:.6e} {y:.6e} {z:.6e}" for x, y, z in corners)]
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid a", ""]))


def rounded_obj(path, places):
    lines = [f"v {x:g} {y:g} {z:g}" for x, y, z in places]
    path.write_text("\n".join([*lines, *(f"f {a} {b} {c}" for a, b, c in CUBE.triangles + 1), ""]))


def binary_ply(path, places):
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(places)}\nproperty float x\nproperty float y\n"
    head += f"property float z\nelement face {len(CUBE.triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    faces = b"".join(b"\x03" + np.array(corners, "<i4").tobytes() for corners in CUBE.triangles)
    path.write_bytes(head.encode() + places.astype("<f4").tobytes() + faces)


def binary_vtk(path, places):
    n = len(CUBE.triangles)
    head = f"# vtk DataFile Version 3.0\nx\nBINARY\nDATASET POLYDATA\nPOINTS {len(places)} float\n"
    lists = np.column_stack([np.full(n, 3), CUBE.triangles]).astype(">i4").tobytes()
    path.write_bytes(head.encode() + places.astype(">f4").tobytes() + f"\nPOLYGONS {n} {4 * n}\n".encode() + lists + b"\n")


def obj_of_floats(path, places):
    write_surface(path, ".obj", places.astype(np.float32).astype(float), NO_QUADS, CUBE.triangles)


def vtu(path, places):
    meshlane = pytest.importorskip("meshlane")
    meshlane.write(str(path), meshlane.Mesh(places.astype(np.float32), [("triangle", CUBE.triangles)]))


COARSE = {
    "binary.stl": (binary_stl, r"accurate to 0.5 \(single precision at 5.8e\+06\), but edges are [0-9.]* long"),
    "scientific.stl": (scientific_stl, r"accurate to 1 \(7 digits at 5.8e\+06\)"),
    "general.obj": (rounded_obj, r"accurate to 10 \(6 digits at 5.8e\+06\)"),
    "binary.ply": (binary_ply, r"accurate to 0.5 \(single precision"),
    "binary.vtk": (binary_vtk, r"accurate to 0.5 \(single precision"),
    "floats.obj": (obj_of_floats, r"accurate to 0.5 \(numbers of single precision"),
    "floats.vtu": (vtu, r"accurate to 0.5 \(single precision"),
}


@pytest.mark.parametrize("name", COARSE)
def test_a_mesh_far_from_the_origin_in_few_digits(name, tmp_path):
    write, told = COARSE[name]
    path = tmp_path / name
    write(path, 20.3 * CUBE.vertices + UTM + 0.123)
    with pytest.warns(UserWarning, match=told + ".*; move the mesh to the origin before exporting it"):
        Surface(file={"path": str(path)})
    write(path, 20.0 * CUBE.vertices)
    assert read_file(str(path), "a surface", ANY).notes == (), "the same at the origin"
    if name == "binary.stl":
        write(path, 20_000.0 * CUBE.vertices + UTM)
        assert read_file(str(path), "a surface", ANY).notes == (), "edges of 10 000 are known well enough"


@pytest.mark.parametrize("place", [UTM, UTM + 1e-5, np.zeros(3)])
@pytest.mark.parametrize("size", [0.3, 20.0, 6.0])
def test_numbers_with_enough_digits_or_near_the_origin_are_not_told(size, place, tmp_path):
    path = tmp_path / "cube.obj"
    write_surface(path, ".obj", size * CUBE.vertices + place, NO_QUADS, CUBE.triangles)
    assert read_file(str(path), "a surface", ANY).notes == ()


def test_readers_know_the_precision_of_a_file(tmp_path):
    binary_ply(tmp_path / "a.ply", CUBE.vertices)
    assert read_ply((tmp_path / "a.ply").read_bytes()).is_single
    binary_vtk(tmp_path / "a.vtk", CUBE.vertices)
    assert read_grid((tmp_path / "a.vtk").read_bytes()).is_single
    (tmp_path / "a.vtp").write_bytes(vtp(CUBE.vertices, CUBE.triangles.tolist(), "binary"))
    contents = read_file(str(tmp_path / "a.vtp"), "a surface", ANY)
    assert not contents.is_single
    assert precision_notes(str(tmp_path / "a.vtp"), contents) == ()
