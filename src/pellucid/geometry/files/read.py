"""Mesh files of a case: their keys, reading of any format, and a check of the precision of their coordinates."""

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np

from pellucid.findings import Refusal, hint
from pellucid.geometry.files.abaqus import read_abaqus
from pellucid.geometry.files.abaqus_keywords import included_files
from pellucid.geometry.files.contents import Contents, Damaged, as_utf8
from pellucid.geometry.files.gmsh import is_gmsh, is_gmsh1, read_gmsh, read_gmsh1
from pellucid.geometry.files.ply import read_ply
from pellucid.geometry.files.surface_formats import read_obj, read_off, read_stl
from pellucid.geometry.files.through_meshlane import read_through_meshlane
from pellucid.geometry.files.vtk_legacy import is_grid, read_grid
from pellucid.geometry.files.vtk_xml import read_vtp, read_vtu
from pellucid.model import InputFile, Model, Vector, check, parameter
from pellucid.users.users_code import file_bytes

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


FileState = tuple[str, int, int]
"""Path, time of the last change [ns], length [bytes]."""


class MeshFile(Model):
    """A mesh file and its unit of length."""

    path: InputFile = parameter("", "mesh file; a relative path is relative to the folder of the case")
    unit: str | None = parameter("", 'unit of length of the file, such as "mm"; alternative to `scale`', None)
    scale: float = parameter("", "factor from the file's unit of length to metres, such as 0.001 for millimetres", 1.0, gt=0)
    offset: Vector = parameter("m", "vector added to the scaled positions", (0.0, 0.0, 0.0))
    repair: bool = parameter("", "repair faults of the mesh if possible, and report the changes as warnings", False)

    @check
    def _has_one_unit(self) -> None:
        if self.unit is not None and self.scale != 1.0:
            text = f"`unit` and `scale` both define the unit of the file: {self.unit} and {self.scale:g} m"
            raise Refusal(text, "remove `unit` or `scale`")
        self.placed(np.zeros((1, 3)))

    def placed(self, points: np.ndarray) -> np.ndarray:
        """Return points of the file in metres, shape (n, 3), shifted by `offset`. Raises ValueError if `unit` is not a
        length."""
        if self.unit is None:
            return points * self.scale + np.array(self.offset)
        from pellucid.units import to_si

        return points * to_si(f"1 {self.unit}", "m") + np.array(self.offset)


def states_of_files(model: Model) -> tuple[FileState, ...]:
    """Return path, modification time [ns] and size [bytes] of each file that a key `path` in a model and its submodels
    names, and of the files that these include. Raises ValueError for a missing file."""
    states: list[FileState] = []
    for name, value in model:
        if isinstance(value, Model):
            states += states_of_files(value)
        elif name == "path":
            check_there(value)
            found = Path(value).stat()
            states.append((value, found.st_mtime_ns, found.st_size))
            for included in included_files(value) if value.lower().endswith(".inp") else []:
                inner = Path(included).stat()
                states.append((included, inner.st_mtime_ns, inner.st_size))
    return tuple(states)


WORST = 0.01  # of the edge length: spacing of the coordinates above which the mesh is distorted
SHARE = 0.1  # quantile of the edge lengths that the spacing is compared with
FAR = 100.0  # distance from the origin in extents, above which the digits of a text file are counted
MOST_DIGITS = 7  # digits of single precision, which many programs write to text files
MOST_BYTES = 20_000_000  # number of bytes of a text file that are examined
NUMBER = re.compile(rb"(?<![\w.])[-+]?(\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?(?![\w.])")


def precision_notes(path: str, contents: Contents) -> tuple[str, ...]:
    """Return notes that warn if the coordinates in a file are too coarse for the edges of its mesh, e.g. in single
    precision far from the origin."""
    points = contents.points
    edges = [
        np.linalg.norm(points[nodes[:, k]] - points[nodes[:, k - 1]], axis=1)
        for base, nodes in ((block.base, block.nodes) for block in contents.blocks)
        if base not in (None, "vertex") and nodes.dtype.kind in "iu"
        for k in range(2 if base == "line" else 3)
    ]
    lengths = np.concatenate([np.zeros(0), *edges])
    lengths = lengths[lengths > 0.0]
    if not len(lengths):
        return ()
    spacing, reason = _spacing(path, points, contents.is_single)
    typical = float(np.quantile(lengths, SHARE, method="lower"))
    if not spacing > WORST * typical:
        return ()
    largest = float(np.abs(points).max())
    text = f"coordinates are only accurate to {spacing:.2g} ({reason} at {largest:.3g}), but edges are {typical:.2g} long"
    return (f"{text}, in the unit of the file; move the mesh to the origin before exporting it",)


def _spacing(path: str, points: np.ndarray, is_single: bool) -> tuple[float, str]:
    """Return the distance between neighbouring numbers that the file can store at the largest coordinate, in the unit of the
    file, and the reason in words. is_single: the file stores single precision.

    The distance is 0 if the file has more digits than single precision.
    """
    size = np.abs(points)
    largest = float(size.max())
    if not 0.0 < largest < float(np.finfo(np.float32).max):
        return 0.0, ""
    single = float(np.spacing(np.float32(largest)))
    coarse = points[size > 0.5 * largest]
    if is_single:
        return single, "single precision"
    if (points.astype(np.float32) == points).all() and (coarse / single % 2 == 1).any():
        return single, "numbers of single precision"
    if largest <= FAR * float(np.ptp(points, axis=0).max()):
        return 0.0, ""
    digits = _digits(path, largest)
    return (10.0 ** (np.floor(np.log10(largest)) + 1 - digits), f"{digits} digits") if 0 < digits <= MOST_DIGITS else (0.0, "")


def _digits(path: str, largest: float) -> int:
    """Return the largest number of digits, including trailing zeros, among the coordinates in a text file whose magnitude is
    at least half the largest; 0 for a binary file."""
    data = as_utf8(file_bytes(path)[:MOST_BYTES])
    if b"\0" in data:
        return 0
    found = 0
    for word in NUMBER.finditer(data):
        if 0.5 * largest <= abs(float(word[0])) <= largest * (1.0 + 1e-12):
            found = max(found, len(word[1].replace(b".", b"").lstrip(b"0")))
    return found
