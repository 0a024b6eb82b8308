"""Files of meshes: read through meshlane, and known again while they do not change."""

import io
import warnings
from contextlib import redirect_stderr, redirect_stdout
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from pellucid.errors import cut
from pellucid.findings import Refusal, hint
from pellucid.model import Model

GMSH = "gmsh"
"""What a .msh file is read as: the reader of another program's files of this ending may never end."""
LONGEST = 200
"""Characters of what a reader says."""

FileState = tuple[str, int, int]
"""Path, time of the last change [ns], length [bytes]."""


def read_mesh(path: str, what: str, readable: str) -> Any:
    """The mesh in a file, as meshlane gives it. Raises ValueError where it cannot be read as `what`, with its article.

    readable: kinds of files that can be. What the readers print does not reach the terminal: it is told in the error, or as a
    warning where the file can be read all the same.
    """
    _check_there(path)
    if find_spec("meshlane") is None:
        raise Refusal(f"reading {path} needs meshlane", "pip install '.[mesh]' in the clone of pellucid")
    import meshlane

    endings = Path(path).name.lower().split(".")[1:]
    if not any("." + ".".join(endings[k:]) in meshlane.extension_to_filetypes for k in range(len(endings))):
        why = f"no format of meshes has the ending .{endings[-1]}" if endings else "its name has no ending"
        raise Refusal(f"{path} cannot be read as {what}: {why}", f"save it as one of {readable}")

    said, ended = io.StringIO(), io.StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(ended):
            mesh = meshlane.read(path, GMSH if endings[-1] == "msh" else None)
    except (Exception, SystemExit) as error:  # its readers raise whatever their parsing meets, or end the program
        found = said.getvalue() if isinstance(error, SystemExit) else str(error)
        reason = cut(" ".join(found.split()).rstrip("."), LONGEST) or f"it does not hold what {Path(path).suffix} files do"
        if isinstance(error, OSError) and error.strerror:
            reason = error.strerror
        elif not isinstance(error, SystemExit | meshlane.ReadError):
            reason = f"its text breaks off or is damaged ({type(error).__name__})"  # whose message may have what is in the file
        raise Refusal(f"{path} cannot be read as {what}: {reason}", f"save it as one of {readable}") from None
    if noted := " ".join((said.getvalue() + ended.getvalue()).split()):
        warnings.warn(f"{path}: {noted}", stacklevel=2)
    _check_corners(mesh, path)
    return mesh


def _check_corners(mesh: Any, path: str) -> None:
    """Raise Refusal for cells with corners that are no points of the file."""
    n = len(mesh.points)
    for block in mesh.cells:
        corners = np.asarray(block.data)
        if corners.dtype.kind in "iu" and corners.size and not 0 <= corners.min() <= corners.max() < n:
            wrong = int(np.argmax(((corners < 0) | (corners >= n)).reshape(len(corners), -1).any(axis=1)))
            text = f"{path}: {block.type} {wrong}, counted from 0, has a corner that is none of the file's {n} points"
            raise Refusal(text, "the file is damaged: save the mesh again")


def _check_there(path: str) -> None:
    """Raise Refusal for a missing file."""
    if not Path(path).is_file():
        there = [found.name for found in Path(path).parent.glob("*")]
        remedy = hint(Path(path).name, there) or "a relative path starts from the folder of the case file"
        raise Refusal(f"there is no file {path}", remedy)


def states_of_files(model: Model) -> tuple[FileState, ...]:
    """The states of all files that a model and the models in it name under the key `path`. Raises ValueError for a missing
    file."""
    states: list[FileState] = []
    for name, value in model:
        if isinstance(value, Model):
            states += states_of_files(value)
        elif name == "path":
            _check_there(value)
            found = Path(value).stat()
            states.append((value, found.st_mtime_ns, found.st_size))
    return tuple(states)
