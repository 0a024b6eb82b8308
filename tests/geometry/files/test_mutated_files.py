"""Files that were sound and are damaged are read, or refused in a sentence with a remedy, soon and without a traceback."""

import random
import time
import warnings

import numpy as np
import pytest
from abaqus_files import CAE
from abaqus_files import PLACES as CUBE
from gmsh_files import gmsh_file
from vtp_files import vtp

from pellucid.findings import Refusal
from pellucid.geometry.files.writing import write_surface
from pellucid.geometry.mesh_survey import survey
from pellucid.geometry.solid_meshes.box import box_mesh
from pellucid.geometry.surfaces.quadrilaterals import CylinderSurface

DRUM = CylinderSurface(start=(0, 0, 0), end=(0, 0, 30), radius=8, rings=2, along=4).mesh()
BOX = box_mesh(np.zeros(3), np.ones(3), (2, 2, 1))
SOLIDS = {
    "text.msh": ("gmsh22", {"binary": False}),
    "binary.msh": ("gmsh22", {"binary": True}),
    "new.msh": ("gmsh", {"binary": False}),
    "binary.vtk": ("vtk", {}),
    "zipped.vtu": ("vtu", {}),
    "abaqus.inp": ("abaqus", {}),
    "nastran.bdf": ("nastran", {}),
    "medit.mesh": ("medit", {}),
}
GMSH = {f"gmsh{version}{'b' * binary}.msh": (version, binary) for version in ("2.2", "4.0", "4.1") for binary in (False, True)}
SURFACES = ("drum.stl", "drum.obj", "drum.ply", "drum.off", "binary.stl", "binary.ply", "old.msh", "drum.vtk", "drum.vtp")
MORE = ("utf16.stl", "strips.ply", "assembly.inp", *GMSH)
STRIPS = "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\nelement tristrips 1\n"
STRIPS += "property list int int vertex_indices\nend_header\n" + "".join(f"{-x} {y} {z}\n" for x, y, z in CUBE)
STRIPS += "20 0 1 3 2 7 6 4 5 0 1 -1 1 5 2 6 -1 0 3 4 7\n"
WORDS = [b"nan", b"inf", b"-1", b"1e308", b"0", b"99999999999999999999", b"-7", b"1e-320", b"x", b"2147483648", b"1000000000"]
BYTES = [b"\xff\xff\xff\xff", b"\x00\x00\x00\x00", b"\xff\xff\xff\x7f", b"\x00\x00\xc0\x7f"]
ROUNDS = 8
LONGEST = 5.0  # s


def old_gmsh(nodes, cells):
    lines = ["$NOD", str(len(nodes)), *(f"{k + 1} {x} {y} {z}" for k, (x, y, z) in enumerate(nodes.tolist())), "$ENDNOD"]
    lines += ["$ELM", str(len(cells))]
    lines += [f"{k + 1} 4 1 1 4 {' '.join(map(str, corners))}" for k, corners in enumerate((cells + 1).tolist())]
    return "\n".join([*lines, "$ENDELM", ""])


def polydata(mesh):
    elements = [*mesh.quads.tolist(), *mesh.triangles.tolist()]
    lines = ["# vtk DataFile Version 3.0", "drum", "ASCII", "DATASET POLYDATA", f"POINTS {len(mesh.vertices)} double"]
    lines += [" ".join(map(str, place)) for place in mesh.vertices.tolist()]
    lines.append(f"POLYGONS {len(elements)} {sum(len(corners) + 1 for corners in elements)}")
    return "\n".join([*lines, *(" ".join(map(str, [len(corners), *corners])) for corners in elements), ""])


def off(mesh):
    elements = [*mesh.quads.tolist(), *mesh.triangles.tolist()]
    lines = [f"OFF {len(mesh.vertices)} {len(elements)} 0", *(" ".join(map(str, place)) for place in mesh.vertices.tolist())]
    return "\n".join([*lines, *(" ".join(map(str, [len(corners), *corners])) for corners in elements), ""])


def write(path):
    """A sound file of the name of the path."""
    if path.name in SOLIDS:
        meshlane = pytest.importorskip("meshlane")
        form, options = SOLIDS[path.name]
        mesh = meshlane.Mesh(BOX.nodes, [("tetra", BOX.cells)], point_sets={"bottom": np.flatnonzero(BOX.nodes[:, 2] == 0.0)})
        meshlane.write(str(path), mesh, file_format=form, **options)
    elif path.name in GMSH:
        path.write_bytes(gmsh_file(*GMSH[path.name], parametric=True))
    elif path.name == "assembly.inp":
        path.write_text(CAE)
    elif path.name == "utf16.stl":
        write_surface(path, ".stl", *DRUM)
        path.write_bytes(path.read_text().encode("utf-16"))
    elif path.name == "strips.ply":
        path.write_text(STRIPS)
    elif path.name.startswith("binary"):
        meshlane = pytest.importorskip("meshlane")
        tables = [("triangle", DRUM.triangulated().triangles.astype(np.int32))]
        meshlane.write_points_cells(str(path), DRUM.vertices, tables, binary=True)
    elif path.name == "old.msh":
        path.write_text(old_gmsh(BOX.nodes, BOX.cells))
    elif path.name == "drum.vtp":
        path.write_bytes(vtp(DRUM.vertices, [*DRUM.quads.tolist(), *DRUM.triangles.tolist()], "zipped"))
    elif path.name == "drum.off":
        path.write_text(off(DRUM))
    elif path.name == "drum.vtk":
        path.write_text(polydata(DRUM))
    else:
        write_surface(path, path.suffix, *DRUM)


def damaged(data, dice):
    """Bytes or words replaced, lines left out, repeated or exchanged, parts cut off, cut out or doubled."""
    kind, found = dice.randrange(8), bytearray(data)
    at = dice.randrange(len(found))
    if kind == 0:
        for _ in range(dice.randint(1, 8)):
            found[dice.randrange(len(found))] = dice.randrange(256)
    elif kind == 1:
        del found[max(at, 1) :]
    elif kind == 2:
        found[at : at + 4] = dice.choice(BYTES)
    elif kind == 3:
        found[at:at] = found[at : at + dice.randint(1, 200)]
    elif kind == 4:
        del found[at : at + dice.randint(1, 100)]
    else:
        lines = bytes(found).split(b"\n")
        k = dice.randrange(len(lines))
        if kind == 5:
            del lines[k : k + dice.randint(1, 3)]
        elif kind == 6:
            lines.insert(k, lines[dice.randrange(len(lines))])
        elif words := lines[k].split():
            words[dice.randrange(len(words))] = dice.choice(WORDS)
            lines[k] = b" ".join(words)
        found = bytearray(b"\n".join(lines))
    return bytes(found)


@pytest.mark.parametrize("name", [*SURFACES, *SOLIDS, *MORE])
def test_damaged_files_are_read_or_refused(name, tmp_path):
    path = tmp_path / name
    write(path)
    sound = path.read_bytes()
    assert survey(str(path), False, 0, 1.0).faults == []
    for seed in range(ROUNDS):
        path.write_bytes(damaged(sound, random.Random(f"{name} {seed}")))
        for repair in (False, True):
            start = time.monotonic()
            with warnings.catch_warnings():
                warnings.simplefilter("error", RuntimeWarning)
                refusal = refusal_of(path, repair)
            assert refusal is None or (str(path) in refusal.text and refusal.remedy)
            assert time.monotonic() - start < LONGEST


def refusal_of(path, repair):
    """Why the file is refused, None where it is read."""
    try:
        survey(str(path), repair, 9 if repair else 0, 1.0)
    except Refusal as refusal:
        return refusal.reason
    return None
