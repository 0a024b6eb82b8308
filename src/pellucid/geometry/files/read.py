"""Reading of any mesh file; its format is recognized from the extension and the first bytes."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from pellucid.findings import Refusal, hint
from pellucid.geometry.files.abaqus import read_abaqus
from pellucid.geometry.files.contents import Contents, Damaged
from pellucid.geometry.files.gmsh import is_gmsh, read_gmsh
from pellucid.geometry.files.gmsh1 import is_gmsh1, read_gmsh1
from pellucid.geometry.files.obj import read_obj
from pellucid.geometry.files.off import read_off
from pellucid.geometry.files.ply import read_ply
from pellucid.geometry.files.precision import precision_notes
from pellucid.geometry.files.stl import read_stl
from pellucid.geometry.files.through_meshlane import read_through_meshlane
from pellucid.geometry.files.vtk_legacy import is_grid, read_grid
from pellucid.geometry.files.vtk_xml import read_vtp, read_vtu
from pellucid.geometry.files.words import as_utf8
from pellucid.system.input_files import file_bytes

SURFACES = "STL (.stl), OBJ (.obj), PLY (.ply), OFF (.off), Gmsh (.msh), VTK (.vtk, .vtp, .vtu)"
SOLIDS = "Gmsh (.msh), VTK (.vtk, .vtu), Abaqus (.inp), Nastran (.bdf, .nas)"
ANY = f"{SURFACES}, Abaqus (.inp), Nastran (.bdf, .nas)"
NODES_OF_ANSYS, HEAD = b"NBLOCK", 100_000
"""Word by which Ansys files are distinguished from Abaqus files (both have the extension .inp), and the number of bytes at the
start of a file that are searched for it."""
FARTHEST = 1e30
"""Largest coordinate in the unit of the file; squares of element volumes do not overflow below it."""

Read = Callable[[bytes], Contents]
BY_ENDING: dict[str, Read] = {
    ".stl": read_stl,
    ".obj": read_obj,
    ".ply": read_ply,
    ".off": read_off,
    ".vtp": read_vtp,
    ".vtu": read_vtu,
}
BY_BEGINNING: dict[str, tuple[tuple[Callable[[bytes], bool], Read], ...]] = {
    ".msh": ((is_gmsh, read_gmsh), (is_gmsh1, read_gmsh1)),
    ".vtk": ((is_grid, read_grid),),
}
"""Readers by extension, each with a test of the first bytes that selects it."""


def read_file(path: str, what: str, readable: str) -> Contents:
    """Read a mesh file. Raises Refusal if it cannot be read.

    what: noun with article for the message, such as "a surface"; readable: supported kinds of files, for the message.
    """
    check_there(path)
    ending = Path(path).suffix.lower()
    try:
        contents = _read(path, ending)
        _check(contents)
    except Damaged as error:
        again = "" if "ending" in str(error) else "write the file again with the program that made it, or "
        remedy = error.remedy or f"{again}save it as one of {readable}"
        raise Refusal(f"{path} cannot be read as {what}: {error}", remedy) from None
    except (MemoryError, OSError) as error:
        reason = "there is not enough memory" if isinstance(error, MemoryError) else error.strerror or str(error)
        raise Refusal(f"{path} cannot be read as {what}: {reason}", "correct this, or use a different file") from None
    return replace(contents, notes=(*contents.notes, *precision_notes(path, contents)))


def _read(path: str, ending: str) -> Contents:
    with Path(path).open("rb") as file:
        head = file.read(HEAD)
    if not head.strip():
        raise Damaged("it is empty")
    if ending == ".inp" and NODES_OF_ANSYS not in head.upper():
        return read_abaqus(path)
    read = BY_ENDING.get(ending)
    for applies, of_beginning in BY_BEGINNING.get(ending, ()):
        if applies(as_utf8(head)[:1000]):
            read = of_beginning
    if read is not None:
        data = file_bytes(path)
        return read(data if read is read_stl else as_utf8(data))
    if ending == ".msh":
        raise Damaged("it does not follow the .msh format of Gmsh")
    return read_through_meshlane(path)


def _check(contents: Contents) -> None:
    """Raise Damaged for coordinates that are not finite, and for elements with corners that are not points of the file."""
    points, n = contents.points, len(contents.points)
    nowhere = np.flatnonzero(~(np.abs(points) <= FARTHEST).all(axis=1))
    if len(nowhere):
        where = ", ".join(f"{x:.6g}" for x in points[nowhere[0]])
        raise Damaged(
            f"point {nowhere[0]} (counted from 0) is at ({where}), but coordinates must be finite and at most {FARTHEST:g}"
        )
    for block in contents.blocks:
        if block.nodes.dtype.kind not in "iu":
            continue
        if block.nodes.size and not 0 <= block.nodes.min() <= block.nodes.max() < n:
            wrong = int(np.argmax(((block.nodes < 0) | (block.nodes >= n)).reshape(len(block.nodes), -1).any(axis=1)))
            raise Damaged(f"{block.kind} {wrong} (counted from 0) has a corner that is not one of the {n} points of the file")
    for name, nodes in contents.node_sets.items():
        if len(nodes) and not 0 <= nodes.min() <= nodes.max() < n:
            raise Damaged(f"the set `{name[:60]}` has a node that is not one of the {n} points of the file")


def check_there(path: str) -> None:
    """Raise Refusal if there is no file at a path."""
    if Path(path).exists() and not Path(path).is_file():
        what = "a folder" if Path(path).is_dir() else "a pipe or a device"
        raise Refusal(f"{path} is {what}, not a file", "set the path of a file")
    if not Path(path).is_file():
        there = [found.name for found in Path(path).parent.glob("*")]
        remedy = hint(Path(path).name, there) or "correct the path; a relative path is relative to the folder of the case file"
        raise Refusal(f"there is no file {path}", remedy)
