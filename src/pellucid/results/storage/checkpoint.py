"""Checkpoints: the whole state of a run in one file that carries its own checksum in its name.

A file `<serial>-<sha256>.npz` appears under its name only when it is complete and on the disk. A process killed while
writing leaves at most a draft, which the next checkpoint overwrites. The last two checkpoints are kept. A checkpoint whose
bytes do not match its name is renamed, and the previous one is used.

If several processes share a run, the first process writes this file. Before that, each other process writes its rows of the
shared arrays to a part `<serial>-<process>-<sha256>.part`. The file lists the names of its parts and appears when all of
them are complete.
"""

import hashlib
import json
import re
import warnings
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from math import inf
from pathlib import Path
from typing import Any

import numpy as np
from numpy.lib.format import read_array_header_1_0, read_magic

from pellucid.results.storage.files import DRAFT, OutputError, explained, sync

KEPT = 2
DAMAGED = ".damaged"
_NUMBERS, _PARTS = "numbers.json", "parts.json"
_NAME = re.compile(r"(\d{6,})-([0-9a-f]{64})\.npz")
_PART = re.compile(r"(\d{6,})-\d+-([0-9a-f]{64})\.part")


def write(
    folder: Path, arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any], parts: Sequence[str] = (), serial: int = 0
) -> Path:
    """Write a checkpoint to `folder` and remove all but the last two checkpoints; return the path of the new file.

    `arrays` may have any names and shapes; `numbers` is anything that JSON can hold (floats are restored exactly). parts:
    file names of the parts, written with the same serial number.

    Raises `OutputError` if the file cannot be written, e.g. on a full disk; the earlier checkpoints are then unchanged.
    """
    texts = {_NUMBERS: json.dumps(numbers), _PARTS: json.dumps(list(parts))}
    with explained(folder.parent):
        _keep_the_last(folder)  # a process killed at the wrong moment left one more
        data = {name: np.frombuffer(text.encode(), np.uint8) for name, text in texts.items()}
        path = _written(folder, DRAFT, dict(arrays) | data, f"{serial or next_serial(folder):06d}-{{}}.npz")
        _keep_the_last(folder)
    return path


def next_serial(folder: Path) -> int:
    """Return the serial number of the next checkpoint in `folder`."""
    return 1 + max((number for number, _, _ in _all(folder)), default=0)


def write_part(folder: Path, arrays: Mapping[str, np.ndarray], process: int, serial: int) -> str:
    """Write the rows of shared arrays that one process computes, as the part of this process in a checkpoint that the first
    process writes; return the file name.

    arrays: these rows, by name of the array. process: number of the process. serial: serial number of the checkpoint.
    Raises `OutputError` if the file cannot be written.
    """
    with explained(folder.parent):
        return _written(folder, f"{DRAFT}-{process}", arrays, f"{serial:06d}-{process}-{{}}.part").name


def _written(folder: Path, draft_name: str, arrays: Mapping[str, np.ndarray], name: str) -> Path:
    """Write arrays to a draft file and rename it when it is complete and synced to the disk; return the final path.

    name: file name with braces in place of the checksum.
    """
    folder.mkdir(parents=True, exist_ok=True)
    draft = folder / draft_name
    try:
        with draft.open("wb") as file:
            np.savez(file, **dict(arrays))  # type: ignore[arg-type]
        path = folder / name.format(_digest(draft))
        sync(draft)
        draft.rename(path)
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)
    sync(folder)
    return path


class RowsInParts:
    """Array of a checkpoint whose rows are stored in several files, one for each process. Rows are read on request, so that
    no process loads the whole array.

    name: name of the array. paths: the files, in the order of the rows.
    """

    def __init__(self, name: str, paths: Sequence[Path]) -> None:
        self._name, self._paths = name, paths

    def __getitem__(self, rows: slice) -> np.ndarray:
        """Read a range of rows; only files that contain rows of the range are read in full."""
        found, first, begin, end = list[np.ndarray](), 0, rows.start or 0, inf if rows.stop is None else rows.stop
        for path in self._paths:
            with np.load(path, allow_pickle=False) as archive, archive.zip.open(f"{self._name}.npy") as head:
                read_magic(head)
                n = read_array_header_1_0(head)[0][0]
                if max(begin, first) < min(end, first + n) or not found:  # of no rows the first file tells what they are like
                    found.append(archive[self._name][max(begin - first, 0) : max(int(min(end - first, n)), 0)].copy())
            first += n
        return np.concatenate(found)


def read_latest(folder: Path, say: Callable[[str], object] = warnings.warn) -> tuple[dict[str, Any], dict[str, Any]] | None:
    """Return the arrays and numbers of the newest undamaged checkpoint in `folder`; None if there is no checkpoint.

    Arrays that several processes share are returned as `RowsInParts`. A damaged checkpoint is reported through `say`,
    renamed to `*.damaged` and skipped. Raises `OutputError` if all checkpoints are damaged.
    """
    found = _all(folder)
    for _, digest, path in reversed(found):
        try:
            arrays = _read(path, digest)
            numbers = json.loads(arrays.pop(_NUMBERS).tobytes())
        except OSError as error:
            reason = error.strerror or str(error)
            text = f"cannot read the checkpoint {path}: {reason}"
            raise OutputError(f"{text}\n    The file itself may be intact. Correct the cause, then resume the run.") from error
        except (ValueError, KeyError) as error:
            say(f"the checkpoint {path} is damaged ({error}); the previous one is used")
            with suppress(OSError):
                path.rename(path.with_suffix(DAMAGED))
            continue
        return arrays, numbers
    if found:
        raise OutputError(f"all checkpoints in {folder} are damaged\n    Start the run again.")
    return None


def _read(path: Path, digest: str) -> dict[str, Any]:
    """Read a checkpoint file and check its checksum `digest`; return its arrays by name. Arrays whose rows are split among
    files are returned as `RowsInParts`."""
    _check(path, digest)
    with np.load(path, allow_pickle=False) as archive:
        parts = [path.parent / part for part in json.loads(archive[_PARTS].tobytes())] if _PARTS in archive.files else []
        shared = {name: RowsInParts(name, [path, *parts]) for name in _names_in(parts)}
        return {name: archive[name] for name in archive.files if name != _PARTS and name not in shared} | shared


def _names_in(parts: Sequence[Path]) -> list[str]:
    """Check that the parts of a checkpoint are complete, and return the names of the arrays whose rows are split among them.
    Raises ValueError for a missing or damaged part."""
    for part in parts:
        found = _PART.fullmatch(part.name)
        if found is None or not part.is_file():
            raise ValueError(f"the file {part.name} is missing")
        _check(part, found[2])
    if not parts:
        return []
    with np.load(parts[0], allow_pickle=False) as archive:
        return list(archive.files)


def _check(path: Path, digest: str) -> None:
    if _digest(path) != digest:
        raise ValueError("the checksum does not match")


def files(folder: Path) -> list[Path]:
    """Return the files written to `folder` by this module: checkpoints, intact or damaged, and drafts."""
    if not folder.is_dir():
        return []
    own = (path for path in folder.iterdir() if _NAME.fullmatch(path.with_suffix(".npz").name))
    whole = [path for path in own if path.suffix in (".npz", DAMAGED)]
    return [folder / DRAFT, *folder.glob(f"{DRAFT}-*"), *whole, *(path for _, path in _parts(folder))]


def _parts(folder: Path) -> list[tuple[int, Path]]:
    """Return the serial number and the path of every part (file with the rows of one process) in the folder."""
    return [(int(match[1]), path) for path in folder.glob("*.part") if (match := _PART.fullmatch(path.name))]


def _keep_the_last(folder: Path) -> None:
    whole = _all(folder)
    for _, _, old in whole[:-KEPT]:
        old.unlink()
    kept = {number for number, _, _ in whole[-KEPT:]}
    last = max(kept, default=0)
    for number, part in _parts(folder):
        if number <= last and number not in kept:  # later ones wait for theirs
            part.unlink(missing_ok=True)


def _all(folder: Path) -> list[tuple[int, str, Path]]:
    """Return serial number, checksum and path of every complete checkpoint, oldest first."""
    if not folder.is_dir():
        return []
    matches = [(_NAME.fullmatch(path.name), path) for path in folder.iterdir()]
    return sorted((int(match[1]), match[2], path) for match, path in matches if match)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
