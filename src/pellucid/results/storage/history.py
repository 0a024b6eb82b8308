"""`history.csv`: a row of names, a row of units, and one row per output time; floats are restored exactly."""

import os
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from pellucid.results.storage.files import OutputError, sync, write_text

HEADER_ROWS = 2


def create(path: Path, units: Mapping[str, str]) -> None:
    """Create a history file. `units`: the columns in order, `time` first, each with its SI unit ("" for none)."""
    names = ",".join(units)
    write_text(path, f"{names}\n#{','.join(unit or '1' for unit in units.values())}\n")


def append(path: Path, row: Sequence[float | int]) -> bytes:
    """Append a row to a history file, and return its bytes as written. row: one value per column, in order. A process
    killed during the call leaves at most an unfinished last line."""
    line = ",".join(repr(value) if isinstance(value, int) else repr(float(value)) for value in row) + "\n"
    handle = os.open(path, os.O_WRONLY | os.O_APPEND)
    try:
        data = line.encode()
        if os.write(handle, data) != len(data):
            raise OSError(28, "No space left on device")
    finally:
        os.close(handle)
    return data


def first(path: Path, rows: int) -> list[bytes]:
    """Return the first `rows` data rows of a history file, each as bytes."""
    return _kept(path, rows)[HEADER_ROWS:]


def cut(path: Path, rows: int) -> None:
    """Remove all but the first `rows` data rows of a history file; the resumed run writes the later rows again."""
    length = sum(map(len, _kept(path, rows)))
    if length < path.stat().st_size:
        os.truncate(path, length)
        sync(path)


def _kept(path: Path, rows: int) -> list[bytes]:
    lines = path.read_bytes().splitlines(keepends=True)[: HEADER_ROWS + rows]
    if len(lines) < HEADER_ROWS + rows or not lines[-1].endswith(b"\n"):
        raise OutputError(f"{path} was changed: it has fewer than the {rows} rows of its checkpoint")
    return lines


def read(path: Path) -> dict[str, np.ndarray]:
    """Return the columns of a history file by name, each of shape (rows,); an unfinished last line is ignored."""
    names, _, rows = _lines(path)
    try:
        table = np.array([[float(cell) for cell in row.split(",")] for row in rows]).reshape(len(rows), len(names))
    except ValueError as error:
        raise OutputError(f"{path} is damaged: {error}") from None
    return {name: np.ascontiguousarray(table[:, column]) for column, name in enumerate(names)}


def read_units(path: Path) -> dict[str, str]:
    """Return the unit of each column of a history file, by name; "1" for a pure number."""
    names, units, _ = _lines(path)
    return dict(zip(names, units, strict=True))


def _lines(path: Path) -> tuple[list[str], list[str], list[str]]:
    if not path.is_file():
        raise OutputError(f"{path.parent} contains no history")
    *lines, _unfinished = path.read_text(encoding="utf-8", errors="replace").split("\n")
    if len(lines) < HEADER_ROWS or not lines[1].startswith("#"):
        raise OutputError(f"{path} does not start with a row of names and a row of units")
    return lines[0].split(","), lines[1][1:].split(","), lines[HEADER_ROWS:]
