"""Formats that meshlane reads: Gmsh 2 and 4, VTK, Abaqus, Nastran, Medit and more."""

import io
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from pellucid.errors import cut
from pellucid.findings import Refusal
from pellucid.geometry.files.abaqus_surfaces import abaqus_surfaces
from pellucid.geometry.files.contents import CORNERS, Block, Contents, Damaged
from pellucid.geometry.files.patience import TooLong, within
from pellucid.geometry.files.sets import sets_of_cells, sets_of_nodes

GMSH = "gmsh"
"""What a .msh file is read as: the reader of another program's files of this ending may never end."""
ABAQUS, ANSYS = "abaqus", "ansysInp"
NODES_OF_ANSYS, HEAD = b"NBLOCK", 100_000
"""What tells the files of two programs of the ending .inp apart, and within how many bytes."""
LEAST_TIME, SLOWEST = 4.0, 100_000.0  # s and bytes/s: readers of text take 1 to 2 MB/s
"""Time that a reader has, as some of them wait for ever for the end of a section that a damaged file has not."""
LONGEST = 200
"""Characters of what a reader says."""


def read_through_meshlane(path: str) -> Contents:
    """What is in a file. Raises Damaged, and Refusal where meshlane is missing.

    What the readers print does not reach the terminal: it is told in the error, or as a note where the file can be read all
    the same.
    """
    if find_spec("meshlane") is None:
        raise Refusal(f"reading {path} needs meshlane", "pip install '.[mesh]' in the clone of pellucid")
    import meshlane

    endings = Path(path).name.lower().split(".")[1:]
    known = [ending for k in range(len(endings)) if (ending := "." + ".".join(endings[k:])) in meshlane.extension_to_filetypes]
    if not known:
        raise Damaged(f"no format of meshes has the ending .{endings[-1]}" if endings else "its name has no ending")
    form = GMSH if known[0] == ".msh" else meshlane.extension_to_filetypes[known[0]][0]
    if known[0] == ".inp":
        with Path(path).open("rb") as file:
            form = ANSYS if NODES_OF_ANSYS in file.read(HEAD).upper() else ABAQUS
    said, ended = io.StringIO(), io.StringIO()
    seconds = LEAST_TIME + Path(path).stat().st_size / SLOWEST

    def read() -> Contents:
        with np.errstate(all="ignore"):
            return _contents(path, meshlane.read(path, form), form)

    try:
        with redirect_stdout(said), redirect_stderr(ended):
            contents = within(seconds, read)
    except TooLong:
        raise Damaged(f"its reader has not come to an end in {seconds:.0f} s, as where an end is missing in the file") from None
    except (Exception, SystemExit) as error:  # its readers raise whatever their parsing meets, or end the program
        found = said.getvalue() if isinstance(error, SystemExit) else str(error)
        reason = cut(" ".join(found.split()).rstrip("."), LONGEST) or f"it does not hold what {Path(path).suffix} files do"
        if isinstance(error, OSError) and error.strerror:
            reason = error.strerror
        elif not isinstance(error, SystemExit | meshlane.ReadError):
            reason = "it breaks off or is damaged"  # the message itself may have what is in the file
        raise Damaged(reason) from None
    noted = " ".join((said.getvalue() + ended.getvalue()).split())
    return replace(contents, notes=(cut(noted, LONGEST),) if noted else ())


def _block(kind: str, nodes: np.ndarray) -> Block:
    """Elements as they are, where they have whole numbers for all of their corners. Raises ReadError."""
    import meshlane

    block = Block(kind, nodes)
    if block.base is not None and not (nodes.dtype.kind in "iu" and nodes.ndim == 2 and nodes.shape[1] >= CORNERS[block.base]):
        raise meshlane.ReadError(f"its elements of type {kind} have not all their corners")
    return block


def _contents(path: str, mesh: Any, form: str) -> Contents:
    points = np.zeros((len(mesh.points), 3))
    points[:, : np.shape(mesh.points)[1]] = mesh.points
    blocks = tuple(_block(block.type, np.asarray(block.data)) for block in mesh.cells)
    node_sets, cell_sets = sets_of_nodes(mesh), sets_of_cells(mesh)
    if form == ABAQUS:
        node_sets |= abaqus_surfaces(path, blocks, cell_sets, node_sets)
    return Contents(f"{form}, through meshlane", points, blocks, node_sets, cell_sets)
