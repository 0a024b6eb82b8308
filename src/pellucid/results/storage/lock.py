"""The lock of a run's folder, so that only one process at a time writes into it.

The signature in the lock file also marks the folder as the folder of a run, because other programs use lock files of this
name too. The kernel releases the lock when the process ends for any reason; the file remains.
"""

import json
import os
import socket
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from datetime import datetime
from pathlib import Path
from typing import Any

from pellucid.errors import UsageError
from pellucid.results.storage.files import explained, usable

if sys.platform != "win32":
    import fcntl

NAME = "run.lock"
PROGRAM = "pellucid"
MOST = 1000  # bytes of a signature


@contextmanager
def held(folder: Path) -> Iterator[None]:
    """Hold the lock of an existing run folder during the block. No other process or thread can write to the folder.

    Raises `UsageError`, with process, machine and time of the owner, if the lock is already held.
    """
    with explained(folder), usable(folder):
        handle = os.open(folder / NAME, os.O_RDWR | os.O_CREAT, 0o666)
    try:
        _take(handle, folder)
        with suppress(OSError):  # on a full disk the lock counts all the same
            _sign(handle)
        yield
    finally:
        os.close(handle)


def is_signed(path: Path) -> bool:
    """Return True if pellucid wrote the lock file at `path`, i.e. if the file contains a signature of the program."""
    return _of(path, "program") == PROGRAM


def is_mine(path: Path) -> bool:
    """Return True if this process was the last owner of the lock file at `path`."""
    return _of(path, "pid") == os.getpid() and _of(path, "host") == socket.gethostname()


def _of(path: Path, key: str) -> object:
    """Return the entry `key` ("program", "pid", "host" or "since") of the signature in a lock file; None if the entry
    cannot be read."""
    try:
        return _signature(path.read_bytes()[:MOST])[key]
    except (OSError, ValueError, KeyError, TypeError):
        return None


def refuse_held(folder: Path) -> None:
    """Raise `UsageError` if any process is writing to the run in `folder`, i.e. holds its lock."""
    if (folder / NAME).is_file():
        with explained(folder), usable(folder):
            handle = os.open(folder / NAME, os.O_RDWR)
        try:
            _take(handle, folder)
        finally:
            os.close(handle)


def _take(handle: int, folder: Path) -> None:
    if sys.platform == "win32":  # without locks
        return
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        text = f"{_owner(handle)} is writing to {folder}"
        raise UsageError(f"{text}.\n    Wait until it has finished, or choose another folder.") from None
    except OSError as error:
        text = (
            f"the disk of {folder} does not support file locks ({error.strerror}); make "
            "sure that only one process writes to this folder"
        )
        warnings.warn(text, stacklevel=2)


def _sign(handle: int) -> None:
    signature = {
        "program": PROGRAM,
        "pid": os.getpid(),
        "host": socket.gethostname(),
        "since": datetime.now().astimezone().isoformat(" ", "seconds"),
    }
    line = f"{json.dumps(signature)}\n".encode()
    os.pwrite(handle, line, 0)  # over the one before, which on a full disk or in a killed process counts on
    os.ftruncate(handle, len(line))


def _owner(handle: int) -> str:
    """Describe the process that holds a lock for a message, from the open lock file with the descriptor `handle`. A process
    that has just acquired the lock may not have signed it yet."""
    try:
        found = _signature(os.pread(handle, MOST, 0))
        return f"process {int(found['pid'])} on {found['host']!s}, since {found['since']!s},"
    except (OSError, ValueError, KeyError, TypeError):
        return "another process"


def _signature(data: bytes) -> Any:
    return json.loads(data.partition(b"\n")[0])
