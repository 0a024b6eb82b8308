"""Formats read by meshlane (VTK, Nastran, Medit and others), with their named sets."""

import ctypes
import io
import re
from collections.abc import Callable
from contextlib import redirect_stderr, redirect_stdout
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from threading import Thread
from typing import Any, TypeVar

import numpy as np

from pellucid.errors import cut
from pellucid.findings import Refusal
from pellucid.geometry.files.contents import CORNERS, GMSH, GROUPS, Block, Contents, Damaged, as_utf8, marked_places, text_of
from pellucid.system.extras import install_command
from pellucid.users.users_code import file_bytes

FORMS = {".inp": "ansysInp"}
"""Names in meshlane of formats whose extension is used by several programs."""
NASTRAN, BEGIN_BULK = "nastran", re.compile(rb"^\s*BEGIN\s+BULK", re.IGNORECASE | re.MULTILINE)
MEDIT, BINARY_MEDIT = "medit", ".meshb"
MEDIT_MARKS = re.compile(r"Required[A-Z]|Corners|Ridges|Normal|Tangent|Parallel")
"""Sections of Medit files written by remeshers that have no elements of their own."""
MEDIT_VERSION = re.compile(r"MeshVersionFormatted\s+(\d)")
"""Version of a Medit file. meshlane reads versions up to 2; the text format of later versions is the same."""
LEAST_TIME, SLOWEST = 4.0, 100_000.0  # s and bytes/s: readers of text take 1 to 2 MB/s
"""Time limit of a reader: some readers wait forever for the end of a section that a damaged file does not have."""
LONGEST = 200
"""Largest number of characters of a reader's output in a message."""


def read_through_meshlane(path: str) -> Contents:
    """Read a mesh file with meshlane. Raises Damaged, and Refusal if meshlane is missing.

    Text that the readers of meshlane print is not shown. It becomes part of the error, or a note if the file can be read.
    """
    if find_spec("meshlane") is None:
        raise Refusal(f"the package meshlane, which is needed to read {path}, is not installed", install_command("mesh"))
    import meshlane

    endings = Path(path).name.lower().split(".")[1:]
    known = [ending for k in range(len(endings)) if (ending := "." + ".".join(endings[k:])) in meshlane.extension_to_filetypes]
    if not known:
        raise Damaged(f"the file name ending .{endings[-1]} is not known" if endings else "its file name has no ending")
    form = FORMS.get(known[0], meshlane.extension_to_filetypes[known[0]][0])
    said, ended = io.StringIO(), io.StringIO()
    seconds = LEAST_TIME + Path(path).stat().st_size / SLOWEST

    def read() -> Contents:
        with np.errstate(all="ignore"):
            if (data := _corrected(path, form)) is None:
                return _contents(meshlane.read(path, form), form)
            with TemporaryDirectory() as folder:
                copy = Path(folder) / f"copy{known[0]}"
                copy.write_bytes(data)
                return _contents(meshlane.read(str(copy), form), form)

    try:
        with redirect_stdout(said), redirect_stderr(ended):
            contents = within(seconds, read)
    except TooLong:
        raise Damaged(f"its reader did not finish in {seconds:.0f} s; the end of a section may be missing") from None
    except (Exception, SystemExit) as error:  # meshlane's readers raise any exception of their parser, or exit
        found = said.getvalue() if isinstance(error, SystemExit) else str(error)
        reason = cut(" ".join(found.split()).rstrip("."), LONGEST) or f"it does not follow the format of {Path(path).suffix}"
        if isinstance(error, OSError) and error.strerror:
            reason = error.strerror
        elif not isinstance(error, SystemExit | meshlane.ReadError):
            reason = "it is truncated or damaged"  # the original message may quote the contents of the file
        raise Damaged(reason) from None
    noted = " ".join((said.getvalue() + ended.getvalue()).split())
    return replace(contents, notes=(cut(noted, LONGEST),) if noted else ())


def _corrected(path: str, form: str) -> bytes | None:
    """Return a corrected text of the file if the reader of the format `form` cannot read it as it is; None otherwise.

    meshlane reads neither UTF-16 nor Nastran cards in lower case or without the first line. For Medit files see
    `_plain_medit`.
    """
    data = file_bytes(path)
    text = as_utf8(data)
    if form == NASTRAN:
        text = b"\n".join(line if line.startswith(b"$") else line.upper() for line in text.splitlines()) + b"\n"
        text = text if BEGIN_BULK.search(text) else b"BEGIN BULK\n" + text
    elif form == MEDIT and not path.lower().endswith(BINARY_MEDIT):
        text = _plain_medit(text_of(text)).encode()
    return None if text == data else text


def _plain_medit(text: str) -> str:
    """Return a Medit file with each count in a separate line and without comments and sections in `MEDIT_MARKS`."""
    found: list[str] = []
    is_kept = True
    for line in text.splitlines():
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        if words[0].isalpha() and words[0].lower() not in ("nan", "inf", "infinity"):
            is_kept = not MEDIT_MARKS.match(words[0])
            if is_kept:
                found += [words[0], *([" ".join(words[1:])] if len(words) > 1 else [])]
        elif is_kept:
            found.append(" ".join(words))
    return MEDIT_VERSION.sub(lambda version: f"MeshVersionFormatted {min(int(version[1]), 2)}", "\n".join(found)) + "\n"


def _block(kind: str, nodes: np.ndarray) -> Block:
    """Return a block of elements of a kind; nodes: shape (m, nodes). Raises ReadError unless there is a whole number for
    each corner of each element."""
    import meshlane

    block = Block(kind, nodes)
    if block.base is not None and not (nodes.dtype.kind in "iu" and nodes.ndim == 2 and nodes.shape[1] >= CORNERS[block.base]):
        raise meshlane.ReadError(f"corners are missing in its elements of type {kind}")
    return block


def _contents(mesh: Any, form: str) -> Contents:
    points = np.zeros((len(mesh.points), 3))
    points[:, : np.shape(mesh.points)[1]] = mesh.points
    blocks = tuple(_block(block.type, np.asarray(block.data)) for block in mesh.cells)
    is_single = np.asarray(mesh.points).dtype == np.float32
    return Contents(f"{form}, through meshlane", points, blocks, sets_of_nodes(mesh), sets_of_cells(mesh), is_single=is_single)


OF_THE_READER = "gmsh:"
"""Prefix of names that meshlane adds and that are not sets."""


def sets_of_nodes(mesh: Any) -> dict[str, np.ndarray]:
    """Return the node numbers of each node set, by name, from a mesh object of meshlane."""
    sets = {name: np.unique(np.asarray(nodes, np.int64)) for name, nodes in (mesh.point_sets or {}).items()}
    for name, values in (mesh.point_data or {}).items():
        if (marked := marked_places(values)) is not None:
            sets.setdefault(name, marked)
    return sets


def sets_of_cells(mesh: Any) -> dict[str, list[np.ndarray]]:
    """Return for each set its name and, for each block of elements, the indices of the elements of the block that belong to the
    set, from a mesh object of meshlane."""
    found = _groups(mesh)
    for name, parts in (mesh.cell_sets or {}).items():
        if not name.startswith(OF_THE_READER):
            found[name] = [np.asarray([] if part is None else part, np.int64) for part in parts]
    for name, blocks in (mesh.cell_data or {}).items():
        if name not in GROUPS and (marked := marked_places(np.concatenate(blocks))) is not None:
            ends = np.cumsum([len(block) for block in blocks])
            parts = np.split(marked, np.searchsorted(marked, ends[:-1]))
            found.setdefault(name, [part - start for part, start in zip(parts, [0, *ends[:-1]], strict=True)])
    return found


def _groups(mesh: Any) -> dict[str, list[np.ndarray]]:
    """Return the numbered element groups by name, or else by number: for each block of elements, the indices of the elements of
    the block that belong to the group. mesh: mesh object of meshlane."""
    data = mesh.cell_data or {}
    named = (mesh.field_data or {}) if GMSH in data else {}
    names = {(int(number), int(dimension)): name for name, (number, dimension) in named.items()}
    none = [np.zeros(0, np.int64) for _ in mesh.cells]
    found = {name: list(none) for name in names.values()}
    for key in sorted(GROUPS & data.keys()):
        for place, (block, numbers) in enumerate(zip(mesh.cells, data[key], strict=True)):
            for number in np.unique(np.asarray(numbers, np.int64)):
                if number:
                    name = names.get((int(number), block.dim), str(number))
                    found.setdefault(name, list(none))[place] = np.flatnonzero(np.asarray(numbers) == number)
    return found


Result = TypeVar("Result")
AGAIN = 0.2  # s between two calls to a halt


class TooLong(Exception):
    """Raised if work did not finish within its time limit."""


class _Halt(BaseException):
    """Exception that is raised in a running thread to stop it; it has no effect if the thread catches all exceptions."""


def within(seconds: float, work: Callable[[], Result]) -> Result:
    """Call `work` in a thread and return its result or raise its error. Raises TooLong after a time of `seconds` [s]; the
    work is then stopped at its next Python line."""
    found: list[Result] = []
    failed: list[BaseException] = []

    def run() -> None:
        try:
            found.append(work())
        except BaseException as error:  # including SystemExit, which the caller handles
            failed.append(error)

    thread = Thread(target=run, daemon=True)
    thread.start()
    try:
        thread.join(seconds)
    finally:
        late = thread.is_alive()
        for _ in range(5):
            if thread.is_alive():
                ctypes.pythonapi.PyThreadState_SetAsyncExc(ctypes.c_ulong(thread.ident or 0), ctypes.py_object(_Halt))
                thread.join(AGAIN)
    if late and not found:
        raise TooLong
    if failed:
        raise failed[0]
    return found[0]
