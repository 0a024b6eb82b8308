"""Checkpoints: the whole state of a run in one file that carries its own checksum in its name.

A file `<serial>-<sha256>.npz` appears under its name only when it is complete and on the disk, so that a process killed
while writing leaves at most a draft behind, which the next one overwrites. The last two are kept; one whose bytes do
not match its name is set aside, and the one before it is used.
"""

import hashlib
import json
import re
import warnings
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np

from pellucid.results.storage.files import DRAFT, OutputError, explained, sync

KEPT = 2
DAMAGED = ".damaged"
_NUMBERS = "numbers.json"
_NAME = re.compile(r"(\d{6,})-([0-9a-f]{64})\.npz")


def write(folder: Path, arrays: Mapping[str, np.ndarray], numbers: Mapping[str, Any]) -> Path:
    """Write a checkpoint to `folder` and remove all but the last two.

    `arrays` may have any names and shapes; `numbers` is anything that JSON can hold (floats come back exactly).
    Raises `OutputError` on a full disk and the like; the earlier checkpoints are then untouched.
    """
    text = json.dumps(numbers)
    with explained(folder.parent):
        folder.mkdir(parents=True, exist_ok=True)
        _keep_the_last(folder)  # a process killed at the wrong moment left one more
        serial = 1 + max((number for number, _, _ in _all(folder)), default=0)
        draft = folder / DRAFT
        try:
            with draft.open("wb") as file:
                np.savez(file, **dict(arrays), **{_NUMBERS: np.frombuffer(text.encode(), np.uint8)})  # type: ignore[arg-type]
            path = folder / f"{serial:06d}-{_digest(draft)}.npz"
            sync(draft)
            draft.rename(path)
        finally:
            with suppress(OSError):
                draft.unlink(missing_ok=True)
        sync(folder)
        _keep_the_last(folder)
    return path


def read_latest(
    folder: Path, say: Callable[[str], object] = warnings.warn
) -> tuple[dict[str, np.ndarray], dict[str, Any]] | None:
    """Arrays and numbers of the newest undamaged checkpoint in `folder`; None where there is none yet.

    A damaged one is told of through `say`, renamed to `*.damaged` and passed over. Raises `OutputError` if there are
    checkpoints and all of them are damaged.
    """
    found = _all(folder)
    for _, digest, path in reversed(found):
        try:
            if _digest(path) != digest:
                raise ValueError("its bytes do not match its checksum")
            with np.load(path, allow_pickle=False) as archive:
                arrays = {name: archive[name] for name in archive.files}
            numbers = json.loads(arrays.pop(_NUMBERS).tobytes())
        except OSError as error:
            reason = error.strerror or str(error)
            raise OutputError(f"cannot read {path}: {reason}\n    it may be whole: mend this, then go on") from error
        except (ValueError, KeyError) as error:
            say(f"the checkpoint {path} is damaged ({error}); trying the one before")
            with suppress(OSError):
                path.rename(path.with_suffix(DAMAGED))
            continue
        return arrays, numbers
    if found:
        raise OutputError(f"every checkpoint in {folder} is damaged; the run must be started again")
    return None


def files(folder: Path) -> list[Path]:
    """What this module wrote to `folder`: checkpoints, whole or damaged, and a draft."""
    if not folder.is_dir():
        return []
    own = (path for path in folder.iterdir() if _NAME.fullmatch(path.with_suffix(".npz").name))
    return [folder / DRAFT, *(path for path in own if path.suffix in (".npz", DAMAGED))]


def _keep_the_last(folder: Path) -> None:
    for _, _, old in _all(folder)[:-KEPT]:
        old.unlink()


def _all(folder: Path) -> list[tuple[int, str, Path]]:
    """Serial number, checksum and path of every complete checkpoint, oldest first."""
    if not folder.is_dir():
        return []
    matches = [(_NAME.fullmatch(path.name), path) for path in folder.iterdir()]
    return sorted((int(match[1]), match[2], path) for match, path in matches if match)


def _digest(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
